// Holds an exclusive owner connection 101/100 to the drive at argv[2] with the implicit scanner of a client that this
// project did not write. Says what happens in one JSON object a line, and does what standard input says:
// `write OFFSET VALUE` puts a 16-bit value into the output data, `close` ends it with a Forward_Close.
"use strict";

const { createInterface } = require("node:readline");
const { IO } = require("st-ethernet-ip");

const OUTPUTS = 18, INPUTS = 28;
const [host, local] = process.argv.slice(2);

const say = what => console.log(JSON.stringify(what));

const scanner = new IO.Scanner(2222, local);
scanner.socket.on("error", error => { say({ error: error.message }); process.exit(1); });
const connection = scanner.addConnection({
    configInstance: { assembly: 1, size: 0 },
    outputInstance: { assembly: 101, size: OUTPUTS },
    inputInstance: { assembly: 100, size: INPUTS },
}, 10, host, undefined);
connection.on("connected", () => say({ event: "connected" }));
connection.on("disconnected", () => say({ event: "disconnected" }));

let packets = 0;
scanner.socket.on("message", () => { ++packets; });
setInterval(() => say({ packets, inputs: connection.inputData.toString("hex") }), 100);

// Its disconnect() would send the Forward_Close as a message of the connection that it closes, which is no connection for
// messages. As long as it knows of none, it is sent unconnected, as it must be.
async function close() {
    connection.tcpController.state.connection.established = false;
    await connection.tcpController.forwardClose();
    say({ event: "closed" });
    process.exit(0);
}

createInterface({ input: process.stdin }).on("line", line => {
    const [verb, offset, value] = line.split(" ");
    if (verb === "write") connection.outputData.writeInt16LE(Number(value), Number(offset));
    if (verb === "close") close().catch(error => { say({ error: error.message }); process.exit(1); });
});
