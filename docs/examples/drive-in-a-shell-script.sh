#!/usr/bin/env bash
# A test of a client against a drive of its own, in bash alone: start, break something, look, stop.
#
#   drive-in-a-shell-script.sh [DIRECTORY OF THE PROGRAMS] [ADDRESS]
set -euo pipefail
bin=${1:-build/bin}
address=${2:-127.0.0.1}

# Control lines go to its standard input and answers come from its standard output, behind the line that says ready.
coproc drive { exec "$bin/servobus-adapter" --bind "$address" --port 0 --log-level error --ready-json --control -; }
pid=$!
trap 'kill "$pid" 2>/dev/null || true' EXIT
read -r -t 10 ready <&"${drive[0]}"
[[ $ready =~ \"port\":([0-9]+) ]]
port=${BASH_REMATCH[1]}

control() {
    echo "$1" >&"${drive[1]}"
    read -r -t 10 answer <&"${drive[0]}"
    [[ $answer == '{"ok":true'* ]] || { echo "the drive refuses $1: $answer" >&2; exit 1; }
}
client() { "$bin/servobus-scanner" get "$address:$port" Statusword --timeout "$1"; }

# The client under test reads one value; put your own here.
client 5

# One reply is lost: the client must give up in time and say so, and get through again afterwards.
control '{"event": "withhold-replies", "count": 1}'
if client 0.5; then
    echo "the client has not noticed that its reply was lost" >&2
    exit 1
elif (($? != 3)); then
    echo "the client ended with another code than 'no answer in time'" >&2
    exit 1
fi
client 5

# The cable is out for a moment, shorter than the client's patience: it must not give up.
control '{"event": "cut-cable", "seconds": 0.3}'
client 5

control '{"command": "stop"}'
wait "$pid"
echo "all as it should be"
