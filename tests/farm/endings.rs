//! How processes end that are told to, or that may write no more: soon, and by a code that says so.

use crate::common;

use common::{Cullet, corpus, free_endpoint, signal, unique};
use std::process::Command;
use std::time::Duration;

const LONG: Duration = Duration::from_secs(60);
/// An interrupted command ends within this.
const SOON: Duration = Duration::from_secs(10);

/// What a client waits for goes on without it.
#[test]
fn clients_that_are_interrupted_end_by_the_code_for_that() {
    let endpoint = free_endpoint();
    // Without a worker no run comes to its end.
    let call = ["coordinator", "--listen", &endpoint, "--out"];
    let _coordinator = Cullet::new(&call).path(&unique("endings")).spawn();
    let who = ["--connect", &endpoint];
    common::until("it is there", LONG, || Cullet::new(&["ps"]).args(&who).output().code == 0);
    let submit =
        |args: &[&str]| Cullet::new(&["submit", &corpus("drop.toml")]).args(args).args(&who);
    let run = submit(&["--detach"]).output().stdout.trim().to_owned();
    for word in ["INT", "HUP", "TERM"] {
        let calls = [
            submit(&[]).args(&["--out"]).path(&unique("endings-out")),
            Cullet::new(&["watch", &run]).args(&who),
            Cullet::new(&["wait", &run]).args(&who),
        ];
        let mut going: Vec<_> = calls.into_iter().map(Cullet::spawn).collect();
        std::thread::sleep(Duration::from_secs(2));
        for one in &mut going {
            assert!(!one.ended(), "{}", one.stderr());
            signal(one.id(), word);
            assert_eq!(one.wait(SOON), Some(130), "{word}");
        }
    }
    let said = Cullet::new(&["show", &run, "--json"]).args(&who).output();
    assert!(said.stdout.contains("running") || said.stdout.contains("queued"), "{}", said.stdout);
}

/// As on a disk that is full: the recording cannot be written, and the command says which file.
#[test]
fn a_file_over_the_limit_of_the_shell_is_an_error_with_words() {
    let out = unique("endings-limit");
    let program = env!("CARGO_BIN_EXE_cullet");
    // Units of 512 or 1024 bytes, as the shell has it.
    let script = "ulimit -f 8; exec \"$0\" run \"$1\" --workers 1 -q --no-pictures --out \"$2\"";
    let mut shell = Command::new("bash");
    let said = shell.args(["-c", script, program, &corpus("drop.toml")]).arg(&out).output();
    let said = said.expect("a shell");
    let text = String::from_utf8_lossy(&said.stderr);
    assert_eq!(said.status.code(), Some(8), "{:?}: {text}", said.status);
    assert!(text.contains("run.mcap") && text.contains("too large"), "{text}");
}
