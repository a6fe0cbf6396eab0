#!/usr/bin/env python3
"""Watches a run as a viewer does, with a client that this project did not write, and compares what
came with the recording.

    pip install websockets==17.4 mcap==1.6.0 mcap-protobuf-support==0.6.0
    cullet run pot --foxglove --out runs/pot &
    python tests/python/watch_run.py ws://127.0.0.1:8765 runs/pot/run.mcap

All channels are subscribed as they are told of. Exit code 0: each message that came is one of the
recording, on its topic, at its time, with its bytes, in its order; schemas are those of the recording
and decode what came; of each channel the last message came; 1: some of it does not hold, each named
on stderr. On stdout: how many messages came, as JSON.
"""

import argparse
import base64
import collections
import json
import pathlib
import struct
import sys
import time
import types

from mcap.reader import make_reader
from mcap_protobuf.decoder import DecoderFactory
from websockets.exceptions import ConnectionClosed
from websockets.sync.client import connect

MESSAGE, TIME = 1, 2
PATIENCE = 60.0


def join(address, protocol):
    """Connects as soon as there is somebody."""
    since = time.monotonic()
    while True:
        try:
            return connect(address, subprotocols=[protocol], max_size=None)
        except OSError:
            if time.monotonic() - since > PATIENCE:
                raise
            time.sleep(0.05)


def watch(viewer, pause):
    """Subscribes everything until the run is over: channels by topic, messages by topic, times."""
    channels, of, came, times = {}, {}, collections.defaultdict(list), []
    try:
        while True:
            frame = viewer.recv(timeout=PATIENCE)
            if isinstance(frame, str):
                told = json.loads(frame)
                if told["op"] == "advertise":
                    for channel in told["channels"]:
                        channels[channel["topic"]] = channel
                        of[len(of) + 1] = channel["topic"]
                        wish = {"id": len(of), "channelId": channel["id"]}
                        viewer.send(json.dumps({"op": "subscribe", "subscriptions": [wish]}))
                elif told["op"] == "status":
                    print(told["message"], file=sys.stderr)
            elif frame[0] == MESSAGE:
                subscription, at = struct.unpack_from("<IQ", frame, 1)
                came[of[subscription]].append((at, bytes(frame[13:])))
                time.sleep(pause)
            elif frame[0] == TIME:
                times += struct.unpack_from("<Q", frame, 1)
    except ConnectionClosed:
        return channels, came, times


def recorded(path):
    """Schemas and messages of a recording, by topic."""
    schemas, messages = {}, collections.defaultdict(list)
    with open(path, "rb") as file:
        for schema, channel, message in make_reader(file).iter_messages(log_time_order=False):
            schemas[channel.topic] = schema
            messages[channel.topic].append((message.log_time, message.data))
    return schemas, messages


def is_part(came, whole):
    """Whether what came is in the whole, in its order."""
    rest = iter(whole)
    return all(message in rest for message in came)


def main():
    parser = argparse.ArgumentParser()
    parser.add_argument("address")
    parser.add_argument("recording", type=pathlib.Path)
    parser.add_argument("--protocol", default="foxglove.sdk.v1")
    parser.add_argument("--pause", type=float, default=0.0, help="after each message [s]")
    args = parser.parse_args()
    complaints = []
    with join(args.address, args.protocol) as viewer:
        if viewer.subprotocol != args.protocol:
            complaints.append(f"it speaks {viewer.subprotocol}, not {args.protocol}")
        channels, came, times = watch(viewer, args.pause)
    since = time.monotonic()
    while not args.recording.exists() and time.monotonic() - since < PATIENCE:
        time.sleep(0.05)
    schemas, messages = recorded(args.recording)
    decode = DecoderFactory()
    for topic, whole in messages.items():
        if topic not in channels:
            complaints.append(f"{topic} was not told of")
            continue
        schema, channel = schemas[topic], channels[topic]
        if (schema.name, base64.b64encode(schema.data).decode()) != (channel["schemaName"], channel["schema"]):
            complaints.append(f"the schema of {topic} is another")
        if not is_part(came[topic], whole):
            complaints.append(f"what came on {topic} is not of the recording")
        if not came[topic] or came[topic][-1] != whole[-1]:
            complaints.append(f"the last message of {topic} did not come")
        told = types.SimpleNamespace(
            id=schema.id, name=channel["schemaName"], encoding="protobuf", data=base64.b64decode(channel["schema"])
        )
        for _, data in came[topic]:
            decode.decoder_for("protobuf", told)(data)
    if times != sorted(times) or not times:
        complaints.append("the time does not go on")
    for complaint in complaints:
        print(complaint, file=sys.stderr)
    count = sum(map(len, came.values()))
    print(json.dumps({"came": count, "recorded": sum(map(len, messages.values())), "topics": len(channels)}))
    return 1 if complaints else 0


if __name__ == "__main__":
    sys.exit(main())
