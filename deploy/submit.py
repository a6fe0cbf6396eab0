"""Submits a scene file and follows it, by docs/protocol.md alone: submit.py ENDPOINT SCENE."""

import json, sys, time, uuid, zenoh

def ask(session, verb, question, bulk=b""):
    payload = json.dumps(question).encode() + (b"\n" + bulk if bulk else b"")
    for _ in range(30):
        for reply in session.get(f"cullet/v1/c/main/rpc/u/python/{verb}", payload=payload, timeout=10.0):
            if reply.ok is not None:
                line, _, rest = reply.ok.payload.to_bytes().partition(b"\n")
                return json.loads(line), rest
            try:
                error = json.loads(reply.err.payload.to_bytes())
            except ValueError:
                continue          # Zenoh's own: ask again
            raise SystemExit(error["error"])
        time.sleep(0.2)
    raise SystemExit("nobody answers")

config = zenoh.Config()
config.insert_json5("mode", '"client"')
config.insert_json5("connect/endpoints", json.dumps([sys.argv[1]]))
config.insert_json5("scouting/multicast/enabled", "false")
with zenoh.open(config) as session:
    scene = open(sys.argv[2], "rb").read()
    key = "scene/scene.toml"
    table = {"name": "from-python", "main": key, "files": [{"key": key, "length": len(scene)}]}
    bundle = json.dumps(table).encode() + b"\n" + scene
    said, _ = ask(session, "submit", {"ticket": uuid.uuid4().hex}, bundle)
    run, following, news = said["run"], 0, {"end": False}
    while not news["end"]:
        news, _ = ask(session, "follow", {"run": run, "from": following, "wait_ms": 1000})
        following = news["next"]
        for line in news["lines"]:
            print(line)
    for file in news["run"]["files"]:
        if file["name"] == "summary.json":
            _, text = ask(session, "fetch", {"run": run, "file": "summary.json", "index": 0})
            print("digest", json.loads(text)["digest"])
    sys.exit(news["run"]["code"])
