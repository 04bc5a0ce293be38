// Reads and writes attributes of the drive at argv[2] with a client that this project did not write.
"use strict";

const assert = require("node:assert/strict");
const { Controller } = require("st-ethernet-ip");

const IDENTITY = 0x01, GENERAL = 0x64, DRIVE = 0x66;

const int16 = value => { const bytes = Buffer.alloc(2); bytes.writeInt16LE(value); return bytes; };
const int32 = value => { const bytes = Buffer.alloc(4); bytes.writeInt32LE(value); return bytes; };

// Unconnected messages, or a class 3 connection that the client opens and closes.
async function talk(host, connected) {
    console.log(connected ? "connected" : "unconnected");
    const client = new Controller(connected);
    client.timeout_sp = 5000;
    await client.connect(host, Buffer.alloc(0), false);

    const get = (classId, attribute) => client.getAttributeSingle(classId, 1, attribute);
    const set = (classId, attribute, bytes) => client.setAttributeSingle(classId, 1, attribute, bytes);
    const expect = async (classId, attribute, bytes, what) => {
        const read = await get(classId, attribute);
        console.log(`${what}: ${read.toString("hex")}`);
        assert.deepEqual(read, bytes, what);
    };
    const refused = async (promise, status, what) => {
        const error = await promise.then(() => null, reason => reason);
        console.log(`${what}: ${JSON.stringify(error)}`);
        assert.equal(error?.generalStatusCode, status, what);
    };

    await expect(IDENTITY, 1, int16(1389), "vendor");
    await expect(IDENTITY, 2, int16(43), "device type");
    await expect(IDENTITY, 3, int16(0x7509), "product code");
    await expect(IDENTITY, 4, Buffer.from([1, 1]), "revision");
    const name = Buffer.from("XENAX Xvi 75V8S");
    await expect(IDENTITY, 7, Buffer.concat([Buffer.from([name.length]), name]), "product name");

    await expect(GENERAL, 0x00, int32(20), "SCurve as delivered");
    await set(GENERAL, 0x00, int32(35));
    await expect(GENERAL, 0x00, int32(35), "SCurve as written");
    await set(GENERAL, 0x00, int32(20));
    await expect(GENERAL, 0x00, int32(20), "SCurve as before");
    await set(DRIVE, 0x41, int32(250000));
    await expect(DRIVE, 0x41, int32(250000), "speed as written");
    await expect(DRIVE, 0x24, int32(0), "actual position");

    if (process.argv.includes("--refusals")) {
        await refused(set(GENERAL, 0x00, int32(101)), 0x09, "SCurve above its limit");
        await refused(set(DRIVE, 0x24, int32(1)), 0x0e, "the actual position is read only");
        await refused(get(GENERAL, 0xee), 0x14, "an attribute that does not exist");
        await expect(GENERAL, 0x00, int32(20), "SCurve after a refused write");
    }
    await client.disconnect();
}

async function main(host) {
    await talk(host, false);
    await talk(host, true);
}

// The client keeps timers of up to its timeout, so leave as soon as the answer is known.
main(process.argv[2]).then(() => process.exit(0), error => { console.error(error); process.exit(1); });
