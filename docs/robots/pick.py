#!/usr/bin/env python3
# SPDX-License-Identifier: Apache-2.0
"""Scan, then print every part and how to take it: python3 pick.py [host [port]]."""
import socket
import sys
import time

host, port = (sys.argv[1:] + ["127.0.0.1", "7110"][len(sys.argv) - 1:])[:2]
connection = socket.create_connection((host, int(port)), timeout=10)
lines = connection.makefile("rw", newline="\n")


def ask(question):
    lines.write(question + "\n")
    lines.flush()
    return [float(word) for word in lines.readline().split()]


ask("DIALECT PLAIN")
print("scan", int(ask("SCAN")[17]))
while ask("STATUS")[0] == 1:
    time.sleep(0.1)
parts = int(ask("OBJECT")[2])
for n in range(1, parts + 1):
    part, grasp = ask(f"PART {n}"), ask(f"GRASP {n}")
    print("part", n, "type", int(part[1]), "at", part[3:6], "grasp", grasp[3:10] if grasp[0] == 0 else None)
