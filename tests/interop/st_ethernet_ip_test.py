#!/usr/bin/env python3
"""The npm package st-ethernet-ip must read and write the drive's attributes, and be refused what is not allowed."""

from judge import HERE, own_address, run, running_drive

address = own_address()
with running_drive(address, "--variant", "75v8s"):
    run("node", HERE / "st_ethernet_ip.js", address, "--refusals")
