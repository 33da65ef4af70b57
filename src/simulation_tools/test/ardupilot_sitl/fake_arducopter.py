#!/usr/bin/env python3
"""Plays ArduPilot SITL's side of the JSON physics link, strictly, without flying.

Takes the options of arducopter that the simulator gives. Sends servo outputs, waits for one line of JSON a
frame, and asks again with the same frame after 0.2 s. Writes what it heard to `heard.json` in the folder
FAKE_RESULTS. FAKE_FRAMES: it ends after so many frames. FAKE_SAYS: a line that it says first. FAKE_EXIT: it
ends at once with this status. FAKE_STAYS: it does not obey SIGTERM, as ArduPilot
while it waits for its physics.

Imports nothing of the simulator: format and units are written from ArduPilot's documentation of the link.
"""

import json
import os
import signal
import socket
import struct
import sys

options = dict(word[2:].split("=", 1) for word in sys.argv[1:])
print(os.environ.get("FAKE_SAYS", "Starting SITL: JSON"), flush=True)
if "FAKE_EXIT" in os.environ:
    sys.exit(int(os.environ["FAKE_EXIT"]))
link = socket.socket(socket.AF_INET, socket.SOCK_DGRAM)
link.settimeout(0.2)
simulator = ("127.0.0.1", int(options["sim-port-out"]))
lines, asked_again = [], 0
if "FAKE_STAYS" in os.environ:
    signal.signal(signal.SIGTERM, signal.SIG_IGN)
for count in range(int(os.environ.get("FAKE_FRAMES", "1000000"))):
    pulses = [1000 + 10 * channel for channel in range(4)] + [1500] * 12
    packet = struct.pack("<HHI16H", 18458, 1000, count, *pulses)
    link.sendto(packet, simulator)
    while True:
        try:
            line = link.recv(4096)
            break
        except TimeoutError:
            asked_again += 1
            link.sendto(packet, simulator)
    assert line.startswith(b"\n")
    assert line.endswith(b"\n")
    lines.append(json.loads(line))
link.settimeout(0.3)
try:
    surplus = bool(link.recv(4096))
except TimeoutError:
    surplus = False
with open(os.path.join(os.environ["FAKE_RESULTS"], "heard.json"), "w") as file:
    json.dump({"lines": lines, "again": asked_again, "surplus": surplus, "options": options}, file)
