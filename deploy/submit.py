"""Submits a scene file and follows its run, as docs/protocol.md describes: submit.py ENDPOINT SCENE."""

import json, sys, time, uuid, zenoh

def request(session, verb, fields, bulk=b""):
    payload = json.dumps(fields).encode() + (b"\n" + bulk if bulk else b"")
    for _ in range(30):
        for reply in session.get(f"cullet/v1/c/main/rpc/u/python/{verb}", payload=payload, timeout=10.0):
            if reply.ok is not None:
                line, _, rest = reply.ok.payload.to_bytes().partition(b"\n")
                return json.loads(line), rest
            try:
                error = json.loads(reply.err.payload.to_bytes())
            except ValueError:
                continue          # Zenoh's own timeout: send the request again
            raise SystemExit(error["error"])
        time.sleep(0.2)
    raise SystemExit("no coordinator answers")

config = zenoh.Config()
config.insert_json5("mode", '"client"')
config.insert_json5("connect/endpoints", json.dumps([sys.argv[1]]))
config.insert_json5("scouting/multicast/enabled", "false")
with zenoh.open(config) as session:
    scene = open(sys.argv[2], "rb").read()
    key = "scene/scene.toml"
    table = {"name": "from-python", "main": key, "files": [{"key": key, "length": len(scene)}]}
    bundle = json.dumps(table).encode() + b"\n" + scene
    response, _ = request(session, "submit", {"ticket": uuid.uuid4().hex}, bundle)
    run, start, update = response["run"], 0, {"end": False}
    while not update["end"]:
        update, _ = request(session, "follow", {"run": run, "from": start, "wait_ms": 1000})
        start = update["next"]
        for line in update["lines"]:
            print(line)
    for file in update["run"]["files"]:
        if file["name"] == "summary.json":
            _, text = request(session, "fetch", {"run": run, "file": "summary.json", "index": 0})
            print("digest", json.loads(text)["digest"])
    sys.exit(update["run"]["code"])
