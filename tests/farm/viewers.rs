//! A run as viewers get it while it goes on, by a client that we did not write.
#![cfg(target_os = "linux")]

use crate::common;

use common::{Cullet, DONE, corpus, file_of, free_port, summary, unique};
use serde_json::Value;
use std::process::{Command, Stdio};
use std::time::Duration;

/// Longest wait for a run here.
const LONG: Duration = Duration::from_secs(300);

#[test]
fn a_viewer_gets_the_recording_as_it_is_made() {
    let _left = common::left::NobodyLeft::watch();
    let named = std::env::var("CULLET_PYTHON").ok();
    let python = named.clone().unwrap_or_else(|| "python3".to_owned());
    let has = Command::new(&python).args(["-c", "import websockets, mcap_protobuf"]).output();
    if !has.is_ok_and(|has| has.status.success()) {
        assert!(named.is_none(), "CULLET_PYTHON: {python} has no websockets");
        let why = "SKIPPED: a viewer: no websockets (name a Python with it: CULLET_PYTHON)";
        eprintln!("{why}");
        return;
    }
    let (out, port) = (unique("viewers"), free_port());
    let script = file_of("tests/python/watch_run.py");
    let watch = |protocol: &str, pause: &str| {
        Command::new(&python)
            .arg(&script)
            .arg(format!("ws://127.0.0.1:{port}"))
            .arg(out.join("run.mcap"))
            .args(["--protocol", protocol, "--pause", pause])
            .stdout(Stdio::piped())
            .stderr(Stdio::piped())
            .spawn()
            .expect("it starts")
    };
    // One that keeps up, and one that dawdles: the run waits for neither.
    let viewers = [("foxglove.sdk.v1", "0"), ("foxglove.websocket.v1", "0.002")];
    let viewers = viewers.map(|(protocol, pause)| watch(protocol, pause));
    let foxglove = format!("--foxglove=127.0.0.1:{port}");
    let call = ["run", &corpus("drop.toml"), "--workers", "1", "--no-pictures", &foxglove, "--out"];
    let mut run = Cullet::new(&call).path(&out).spawn();
    let code = run.wait(LONG);
    let said = run.stderr();
    assert!(code.is_some_and(|code| DONE.contains(&code)), "{code:?}: {said}");
    assert!(said.contains(&format!("can open ws://127.0.0.1:{port}")), "{said}");
    for viewer in viewers {
        let said = viewer.wait_with_output().expect("it ends");
        let why = String::from_utf8_lossy(&said.stderr);
        assert!(said.status.success(), "{why}");
        let counts: Value = serde_json::from_slice(&said.stdout).expect("JSON");
        assert!(counts["came"].as_u64() > Some(20), "{counts}");
    }
    // Who watches changes nothing.
    assert_eq!(summary(&out)["digest"], common::quiet_digest(&[]));
}
