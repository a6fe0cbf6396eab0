//! The pages of operations tried to the letter, and what is in `deploy/` held against the tools
//! that read it.

use crate::common;

use common::{file_of, unique, until};
use std::fs;
use std::io::Write;
use std::path::Path;
use std::process::{Command, Output, Stdio};
use std::time::Duration;

/// Says that a test was not made, also where what tests print is not shown.
fn skip(why: &str) {
    let mut aloud = std::io::stderr();
    writeln!(aloud, "SKIPPED, and nothing is shown: {why}").ok();
}

/// The blocks of a page that are of that language, in order.
fn blocks(page: &str, language: &str) -> Vec<String> {
    let text = fs::read_to_string(file_of(page)).expect("a page");
    let mut all = Vec::new();
    for part in text.split(&format!("```{language}\n")).skip(1) {
        all.push(part.split("```").next().unwrap_or_default().to_owned());
    }
    all
}

/// The Python for programs that this project did not write, and whether somebody has named it: then
/// it has what they need.
fn python() -> (String, bool) {
    let named = std::env::var("CULLET_PYTHON").ok();
    (named.clone().unwrap_or_else(|| "python3".to_owned()), named.is_some())
}

fn ports<const N: usize>() -> [String; N] {
    [(); N].map(|()| common::free_port().to_string())
}

/// A folder in which the repository's files are where the pages say.
fn desk(name: &str) -> std::path::PathBuf {
    let folder = unique(name);
    fs::create_dir_all(&folder).expect("a folder");
    for there in ["deploy", "tests"] {
        std::os::unix::fs::symlink(
            file_of(there).canonicalize().expect("it is there"),
            folder.join(there),
        )
        .expect("a link");
    }
    folder
}

/// Runs a script with the binary under test in its path.
fn shell(folder: &Path, script: &str) -> Output {
    let program = Path::new(env!("CARGO_BIN_EXE_cullet")).parent().expect("a folder");
    let path = format!("{}:{}", program.display(), std::env::var("PATH").unwrap_or_default());
    let mut call = Command::new("bash");
    call.args(["-c", script]).current_dir(folder).env("PATH", path).stdin(Stdio::null());
    call.output().expect("bash starts")
}

/// No process of ours that was told of this folder is left behind.
fn nobody_is_left(folder: &Path) {
    let words = folder.to_string_lossy().into_owned();
    until("all processes end", Duration::from_secs(20), || {
        let all = fs::read_dir("/proc").into_iter().flatten().flatten();
        !all.into_iter().any(|process| {
            let place = fs::read_link(process.path().join("cwd"));
            place.is_ok_and(|place| place.to_string_lossy() == words)
        })
    });
}

#[test]
fn the_page_of_operations_can_be_typed_from_top_to_bottom() {
    if Command::new("curl").arg("--version").output().is_err() {
        return skip("docs/operations.md: there is no curl");
    }
    let folder = desk("operations");
    let [first, second, third, metrics, web] = ports();
    let mut script = String::from("set -eu\ntrap 'kill $(jobs -p) 2>/dev/null; wait' EXIT\n");
    for block in blocks("docs/operations.md", "sh") {
        for line in block.lines() {
            script += line;
            // Who types is slower than a program that starts.
            script += if line.split(" #").next().is_some_and(|l| l.trim_end().ends_with(" &")) {
                "\nsleep 2\n"
            } else {
                "\n"
            };
        }
    }
    let script = script
        .replace("/var/lib/cullet", "state")
        .replace("7447", &first)
        .replace("7448", &second)
        .replace("7449", &third)
        .replace("9464", &metrics)
        .replace("8080", &web)
        .replace("scenes/bullet", "tests/corpus/drop.toml");
    let said = shell(&folder, &format!("set -x\n{script}"));
    let (out, text) =
        (String::from_utf8_lossy(&said.stdout), String::from_utf8_lossy(&said.stderr));
    assert!(said.status.success(), "{out}\n{text}");
    for made in [
        "runs/drop-1/summary.json",
        "runs/drop-2/run.mcap",
        "here/preview.png",
        "runs/seeds-1/sheet.png",
    ] {
        assert!(folder.join(made).is_file(), "{made} is not there\n{text}");
    }
    for words in [
        "run 4 is paused",
        "run 4 is cancelled",
        "cullet_runs{",
        "\"jobs_waiting\":",
        "\"line\":",
        "a gets no more jobs",
        "run 4 is deleted",
    ] {
        assert!(out.contains(words), "{words:?} is not in {out}");
    }
    let digest = |run: &str| common::summary(&folder.join(run))["digest"].clone();
    assert_eq!(digest("runs/drop-1"), digest("state/recordings/drop-7"), "the killed one differs");
    assert_eq!(digest("runs/drop-1"), digest("secure/recordings/drop-1"), "the secure one differs");
    assert_eq!(digest("runs/drop-1"), digest("by-night/recordings/drop-1"), "at night it differs");
    assert!(!folder.join("state/recordings/drop-4").exists(), "it is deleted and there");
    nobody_is_left(&folder);
}

#[test]
fn the_farm_of_one_command_works_and_leaves_nobody_behind() {
    let folder = desk("local");
    let help = shell(&folder, "deploy/local.sh --help");
    let told = String::from_utf8_lossy(&help.stdout);
    assert!(help.status.success() && told.ends_with("PORT=7447\n"), "{told}");
    assert_eq!(shell(&folder, "deploy/local.sh --hepl").status.code(), Some(64));
    let [port] = ports();
    let script = format!(
        "set -eu\nPORT={port} deploy/local.sh farm > said 2> errors &\nFARM=$!\n\
         trap 'kill $FARM; wait $FARM' EXIT\nuntil grep -q export said; do sleep 0.1; done\n\
         eval \"$(grep export said)\"\nuntil cullet doctor; do sleep 0.5; done\n\
         cullet submit tests/corpus/drop.toml -q --out out\ncullet workers\n"
    );
    let said = shell(&folder, &script);
    let errors = fs::read_to_string(folder.join("errors")).unwrap_or_default();
    let text = String::from_utf8_lossy(&said.stderr);
    assert!(said.status.success(), "{text}{errors}");
    let out = String::from_utf8_lossy(&said.stdout);
    assert!(out.contains("worker-1") && out.contains("worker-2"), "{out}{errors}");
    assert_eq!(common::summary(&folder.join("out"))["digest"], common::quiet_digest(&[]));
    nobody_is_left(&folder);
}

#[test]
fn a_program_in_python_needs_the_page_of_the_protocol_alone() {
    let shipped = fs::read_to_string(file_of("deploy/submit.py")).expect("a script");
    let page = blocks("docs/protocol.md", "python").concat();
    let code = shipped.split_once("\n\n").map_or("", |(_, code)| code);
    assert_eq!(code, page, "the page and deploy/submit.py differ");
    let (python, named) = python();
    let has = Command::new(&python).args(["-c", "import zenoh"]).output();
    if !has.is_ok_and(|has| has.status.success()) {
        assert!(!named, "CULLET_PYTHON: {python} has no eclipse-zenoh");
        return skip("deploy/submit.py: no eclipse-zenoh (name a Python with it: CULLET_PYTHON)");
    }
    let folder = desk("python");
    let [port] = ports();
    let script = format!(
        "set -eu\ncullet coordinator --listen tcp/127.0.0.1:{port} --workers 1 &\n\
         trap 'kill $!; wait $!' EXIT\n\
         until cullet ps --connect tcp/127.0.0.1:{port} >/dev/null 2>&1; do sleep 0.1; done\n\
         {python} deploy/submit.py tcp/127.0.0.1:{port} tests/corpus/drop.toml\n"
    );
    let said = shell(&folder, &script);
    let text = String::from_utf8_lossy(&said.stderr);
    assert!(said.status.success(), "{text}");
    let want = common::quiet_digest(&[]);
    let digest = format!("digest {}", want.as_str().expect("a digest"));
    assert!(String::from_utf8_lossy(&said.stdout).contains(&digest), "{text}");
    nobody_is_left(&folder);
}

/// What Zenoh's own router is to be given is what the program prints.
#[test]
fn the_routers_configuration_is_what_is_printed() {
    let folder = unique("zenohd");
    let certs = folder.join("etc/cullet/certs");
    fs::create_dir_all(&certs).expect("a folder");
    common::certificates(&certs, &["router"], &[]);
    let call = ["router", "--listen", "tls/0.0.0.0:7447", "--print-config", "--roles"];
    let roles = file_of("deploy/roles.toml");
    let call = common::Cullet::new(&call).path(&roles).args(&["--tls"]);
    let said = call.path(&certs.join("router")).output();
    assert_eq!(said.code, 0, "{}", said.stderr);
    let printed = said.stdout.replace(&*folder.to_string_lossy(), "");
    let kept = fs::read_to_string(file_of("deploy/zenohd.json5")).expect("a file");
    let kept: Vec<&str> = kept.lines().filter(|line| !line.starts_with("//")).collect();
    assert!(printed.lines().eq(kept), "print it again: its first lines say how");
}

#[test]
fn units_are_taken_by_systemd() {
    let verify = |units: &[std::path::PathBuf]| {
        Command::new("systemd-analyze").arg("verify").args(units).output()
    };
    let folder = unique("units");
    fs::create_dir_all(&folder).expect("a folder");
    let names = ["cullet-router", "cullet-coordinator", "cullet-worker@"];
    let units = names.map(|name| {
        let name = format!("{name}.service");
        let text = fs::read_to_string(file_of("deploy").join(&name)).expect("a unit");
        let program = "/usr/local/bin/cullet";
        let start = text.lines().find_map(|line| line.strip_prefix("ExecStart=")).expect("a start");
        // The program itself takes these arguments.
        let words: Vec<&str> = start.split(' ').skip(1).collect();
        let help = common::Cullet::new(&[words[0], "--help"]).output();
        for word in words.iter().filter(|word| word.starts_with("--")) {
            assert!(help.stdout.contains(word), "{name}: {word} is no argument");
        }
        let path = folder.join(name);
        // There is no such program while this is a test.
        fs::write(&path, text.replace(program, env!("CARGO_BIN_EXE_cullet"))).expect("a unit");
        path
    });
    let Ok(said) = verify(&units) else {
        return skip("units: there is no systemd-analyze");
    };
    let text = String::from_utf8_lossy(&said.stderr);
    assert!(said.status.success() && text.is_empty(), "{text}");
    let broken = folder.join("broken.service");
    fs::write(&broken, "[Service]\nExecStart=/bin/true\nRestart=perhaps\n").expect("a unit");
    let said = verify(&[broken]).expect("it was there");
    assert!(!said.stderr.is_empty(), "it takes everything");
}

/// By schema they were held once, by hand: see `deploy/README.md`.
#[test]
fn container_files_name_what_is_there() {
    let compose = fs::read_to_string(file_of("deploy/compose.yaml")).expect("a file");
    let cluster = fs::read_to_string(file_of("deploy/kubernetes.yaml")).expect("a file");
    for (name, text) in [("compose", &compose), ("kubernetes", &cluster)] {
        for command in ["router", "coordinator", "worker"] {
            let help = common::Cullet::new(&[command, "--help"]).output().stdout;
            for word in arguments_of(text, command) {
                assert!(help.contains(&word), "{name}: {command} has no {word}");
            }
        }
    }
    let image = fs::read_to_string(file_of("deploy/Containerfile")).expect("a file");
    let copied = image
        .lines()
        .filter_map(|line| line.strip_prefix("COPY "))
        .filter(|l| !l.contains("--from"));
    for line in copied {
        let words: Vec<&str> = line.split(' ').collect();
        for word in &words[..words.len() - 1] {
            assert!(file_of(word).exists(), "{word} is copied and not there");
        }
    }
    let (python, named) = python();
    let Ok(said) = Command::new(&python)
        .args(["-c", "import sys, yaml\nfor f in sys.argv[1:]: list(yaml.safe_load_all(open(f)))"])
        .args([file_of("deploy/compose.yaml"), file_of("deploy/kubernetes.yaml")])
        .output()
    else {
        return skip("YAML: there is no python3");
    };
    let text = String::from_utf8_lossy(&said.stderr);
    if text.contains("No module named 'yaml'") && !named {
        return skip("YAML: python3 has no yaml");
    }
    assert!(said.status.success(), "{text}");
}

/// Every pod of the cluster is closed, and what is opened is each port for whom it is meant.
#[test]
fn policies_of_the_cluster_open_each_port_for_whom_it_is_meant() {
    let cluster = fs::read_to_string(file_of("deploy/kubernetes.yaml")).expect("a file");
    let policies: Vec<&str> =
        cluster.split("\n---\n").filter(|part| part.contains("kind: NetworkPolicy")).collect();
    let closed = |part: &&&str| part.contains("podSelector: {}") && !part.contains("ingress:");
    assert_eq!(policies.iter().filter(closed).count(), 1, "nothing is closed by itself");
    let of = |app: &str| {
        let own = format!("spec:\n  podSelector:\n    matchLabels: {{app: {app}}}\n");
        let mut found = policies.iter().filter(move |part| part.contains(&own));
        let policy = found.next().unwrap_or_else(|| panic!("{app} has no policy"));
        assert!(found.next().is_none() && policy.contains("policyTypes: [Ingress]"));
        policy.split_once("  ingress:\n").expect("what is let in").1.to_owned()
    };
    let (router, coordinator) = (of("cullet-router"), of("cullet-coordinator"));
    assert!(router.contains("values: [cullet-coordinator, cullet-worker]"), "{router}");
    assert!(router.ends_with("ports:\n        - {protocol: TCP, port: 7447}"), "{router}");
    assert!(!router.contains("namespaceSelector"), "{router}");
    let from = "namespaceSelector:\n            \
                matchLabels: {kubernetes.io/metadata.name: monitoring}\n";
    assert!(coordinator.contains(from) && !coordinator.contains("podSelector"), "{coordinator}");
    assert!(coordinator.trim_end().ends_with("port: metrics}"), "{coordinator}");
    assert_eq!(policies.len(), 3, "nobody else is let in anywhere");
    // Where metrics are answered beyond the pod they are behind a policy.
    assert!(cluster.contains("- 0.0.0.0:9464\n") && cluster.contains("- --insecure\n"));
}

/// Arguments after a subcommand, in a list of either form.
fn arguments_of(text: &str, command: &str) -> Vec<String> {
    let mut found = Vec::new();
    let mut inside = false;
    for line in text.lines() {
        let words = line.trim().trim_start_matches("- ");
        let list = words.starts_with("command:") || words.starts_with("args:");
        if list && words.contains('[') {
            let items: Vec<&str> = words.split(['[', ',', ']']).map(str::trim).collect();
            if items.get(1) == Some(&command) {
                found.extend(items[2..].iter().map(|item| (*item).to_owned()));
            }
        } else if list {
            inside = false;
        } else if line.trim() == format!("- {command}") {
            inside = true;
        } else if inside && line.trim().starts_with("- ") {
            found.push(words.to_owned());
        } else {
            inside = false;
        }
    }
    found.retain(|item| item.starts_with("--"));
    assert!(!found.is_empty(), "{command} is not in it");
    found
}
