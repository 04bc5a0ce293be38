#!/bin/sh
# The drive of CMakeLists.txt: start, stop, one control line, or one run of the client.
set -eu
cd "$(dirname "$0")"
control=$DRIVE_DIR/control
said=$DRIVE_DIR/said # the line that says ready, and then an answer to each control line

# A number that the first line tells; the first of that name.
told() { head -n 1 "$said" | grep -oE "\"$1\":[0-9]+" | head -n 1 | cut -d: -f2; }

case $1 in
start)
    rm -rf "$DRIVE_DIR"
    mkdir -p "$DRIVE_DIR"
    mkfifo "$control"
    # Opened for both ways a fifo waits for nobody. Nothing of CTest's stays open behind its back.
    "$SERVOBUS_BIN/servobus-adapter" --bind "$DRIVE_ADDRESS" --port 0 --ready-json --control - \
        <>"$control" >"$said" 2>"$DRIVE_DIR/log" &
    pid=$!
    until grep -q '"ready":true' "$said"; do
        kill -0 "$pid" 2>/dev/null || { cat "$DRIVE_DIR/log" >&2; exit 1; }
        sleep 0.01
    done
    ;;
control)
    lines=$(wc -l <"$said")
    echo "$2" >"$control"
    until [ "$(wc -l <"$said")" -gt "$lines" ]; do sleep 0.01; done
    tail -n 1 "$said" | grep -q '^{"ok":true'
    ;;
client)
    "$SERVOBUS_BIN/servobus-scanner" get "$DRIVE_ADDRESS:$(told port)" Statusword --timeout "$2"
    ;;
stop)
    pid=$(told pid)
    echo '{"command": "stop"}' >"$control"
    while kill -0 "$pid" 2>/dev/null; do sleep 0.01; done
    ;;
esac
