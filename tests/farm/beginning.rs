//! What a person meets in the first hour: a scene to begin with, completions and manual pages,
//! advice in errors, runs that say why nothing happens, files that are no files.

use crate::common;

use common::{Cullet, Said, corpus, summary, unique, until};
use std::fs;
use std::path::{Path, PathBuf};
use std::process::Command;
use std::sync::OnceLock;
use std::time::Duration;

const LONG: Duration = Duration::from_secs(300);

/// The folder of a run of the drop scene, made once.
fn a_run() -> &'static Path {
    static RUN: OnceLock<PathBuf> = OnceLock::new();
    RUN.get_or_init(|| {
        let out = unique("beginning");
        let call = ["run", &corpus("drop.toml"), "-q", "--no-pictures", "--out"];
        let said = Cullet::new(&call).path(&out).output();
        assert_eq!(said.code, 0, "{}", said.stderr);
        out
    })
}

/// A path that is not there yet, with an ending.
fn named(name: &str, ending: &str) -> PathBuf {
    unique(name).with_extension(ending)
}

fn says(said: &Said, code: i32, words: &[&str]) {
    assert_eq!(said.code, code, "{words:?}: {}{}", said.stdout, said.stderr);
    for words in words {
        assert!(said.stderr.contains(words), "{words:?} is not in: {}", said.stderr);
    }
    assert!(!said.stderr.contains("os error"), "{}", said.stderr);
}

#[test]
fn a_new_scene_checks_and_runs_well_and_nothing_is_overwritten() {
    let _left = common::left::NobodyLeft::watch();
    let folder = unique("new").join("first");
    let made = Cullet::new(&["new"]).path(&folder).output();
    assert_eq!(made.code, 0, "{}", made.stderr);
    let text = fs::read_to_string(folder.join("scene.toml")).expect("a scene");
    for key in ["[world]", "[fracture]", "[[body]]", "[expect]", "[view]", "# [[material]]"] {
        assert!(text.contains(key), "{key} is not shown");
    }
    assert!(folder.join("scene.schema.json").is_file());
    let check = Cullet::new(&["check"]).path(&folder).output();
    assert_eq!((check.code, check.stdout.contains("warning")), (0, false), "{}", check.stdout);
    let run = Cullet::new(&["run", "-q", "--no-pictures"]).path(&folder).args(&["--out"]);
    let out = unique("new-run");
    let run = run.path(&out).output();
    assert_eq!(run.code, 0, "{}", run.stderr);
    assert!(summary(&out)["fragments"].as_u64() >= Some(2));
    fs::write(folder.join("scene.toml"), "mine").expect("a file");
    says(&Cullet::new(&["new"]).path(&folder).output(), 64, &["it is there already"]);
    assert_eq!(fs::read_to_string(folder.join("scene.toml")).expect("a file"), "mine");
}

#[test]
fn shells_complete_commands_and_each_command_has_a_manual_page() {
    let _left = common::left::NobodyLeft::watch();
    for (shell, mark) in [("bash", "complete -F"), ("zsh", "#compdef cullet"), ("fish", "complete")]
    {
        let said = Cullet::new(&["completions", shell]).output();
        assert_eq!(said.code, 0, "{}", said.stderr);
        for word in [mark, "submit", "inspect"] {
            assert!(said.stdout.contains(word), "{shell}: {word:?} is not there");
        }
    }
    let folder = unique("man").join("pages");
    let said = Cullet::new(&["man"]).path(&folder).output();
    assert_eq!(said.code, 0, "{}", said.stderr);
    let page = |name: &str| fs::read_to_string(folder.join(name)).expect("a page");
    assert!(page("cullet.1").contains("Exit codes"), "{}", page("cullet.1"));
    assert!(
        page("cullet-run.1").contains("pictures") && page("cullet-submit.1").contains("priority")
    );
}

#[test]
fn arguments_that_are_none_are_told_with_what_is_meant() {
    let _left = common::left::NobodyLeft::watch();
    let drop = corpus("drop.toml");
    let said = Cullet::new(&["run", &drop, "--seed", "3"]).output();
    says(&said, 64, &["--seed", "--set world.seed=3"]);
    let said = Cullet::new(&["check", &drop, "--duration=2"]).output();
    says(&said, 64, &["--set world.duration=2"]);
    for verb in ["show", "delete", "cancel"] {
        says(&Cullet::new(&[verb, "abc"]).output(), 64, &["'abc'", "a run is named by its number"]);
    }
    for verb in ["ps", "submit", "show", "workers", "fetch", "worker"] {
        let help = Cullet::new(&[verb, "--help"]).output().stdout;
        assert!(help.contains("[default: tcp/127.0.0.1:7447]"), "{verb}: {help}");
    }
    let endpoint = common::free_endpoint();
    let ps = Cullet::new(&["ps", "--patience", "0.5"]).env("CULLET_CONNECT", &endpoint).output();
    says(&ps, 69, &[&endpoint, "--connect or CULLET_CONNECT names another place"]);
}

#[test]
fn a_folder_of_a_run_stands_for_its_recording_and_another_folder_is_told() {
    let _left = common::left::NobodyLeft::watch();
    let run = a_run();
    let file = Cullet::new(&["inspect", "--json"]).path(&run.join("run.mcap")).output();
    let folder = Cullet::new(&["inspect", "--json"]).path(run).output();
    assert_eq!((folder.code, &folder.stdout), (0, &file.stdout), "{}", folder.stderr);
    let picture = unique("still").with_extension("png");
    let small = ["--size", "160x120", "-o"];
    let still = Cullet::new(&["still"]).path(run).args(&small).path(&picture).output();
    assert_eq!(still.code, 0, "{}", still.stderr);
    assert!(fs::read(&picture).expect("a picture").starts_with(b"\x89PNG"));
    let empty = unique("no-run");
    fs::create_dir_all(&empty).expect("a folder");
    for verb in ["inspect", "still", "preview", "recover", "export"] {
        let said = Cullet::new(&[verb]).path(&empty).output();
        says(&said, 74, &["it is a folder, and there is no run.mcap in it"]);
    }
    let said = Cullet::new(&["still"]).path(run).args(&["-o"]).path(&empty).output();
    says(&said, 74, &["it is a folder"]);
    assert_eq!(fs::read_dir(&empty).expect("a folder").count(), 0);
}

#[test]
fn an_export_is_what_its_name_says_and_never_the_place_of_its_recording() {
    let _left = common::left::NobodyLeft::watch();
    let run = a_run();
    let export = |file: &Path, args: &[&str]| {
        Cullet::new(&["export"]).path(run).args(&["-o"]).path(file).args(args).output()
    };
    for (ending, start) in [("glb", "glTF"), ("usda", "#usda 1.0"), ("csv", "name,id,object,")] {
        let file = named("export", ending);
        let said = export(&file, &["--json"]);
        assert_eq!(said.code, 0, "{}", said.stderr);
        let path = format!("{:?}", file.to_string_lossy());
        assert!(
            said.stdout.contains(&path) && said.stdout.contains("\"bodies\": "),
            "{}",
            said.stdout
        );
        assert!(fs::read(&file).expect("a file").starts_with(start.as_bytes()), "{ending}");
    }
    let moved = named("export", "abc");
    says(&export(&moved, &[]), 64, &["no maintained library writes Alembic", ".usda"]);
    let late = named("export", "glb");
    says(&export(&late, &["--at", "7"]), 64, &["no moments from 7 s to 7 s", "from 0 to 0.15 s"]);
    assert!(!moved.exists() && !late.exists());
    let own = named("own", "glb");
    let bytes = fs::read(run.join("run.mcap")).expect("a recording");
    fs::write(&own, &bytes).expect("a file");
    let said = Cullet::new(&["export"]).path(&own).args(&["-o"]).path(&own).output();
    says(&said, 64, &["it is a recording, and nothing is written over one; name another file"]);
    assert!(fs::read(&own).expect("a recording") == bytes, "the recording is another one");
}

#[test]
fn a_still_has_a_moment_of_its_run_a_png_and_never_the_place_of_its_recording() {
    let _left = common::left::NobodyLeft::watch();
    let run = a_run();
    let still = |args: &[&str]| Cullet::new(&["still"]).path(run).args(args).output();
    says(&still(&["--at", "7"]), 64, &["no moment 7 s", "from 0 to 0.15 s"]);
    let (picture, own) = (named("still", "jpg"), named("own", "png"));
    says(&still(&["-o", &picture.to_string_lossy()]), 64, &["is written as PNG; name it .png"]);
    assert!(!picture.exists());
    let bytes = fs::read(run.join("run.mcap")).expect("a recording");
    fs::write(&own, &bytes).expect("a file");
    let said = Cullet::new(&["still"]).path(&own).args(&["-o"]).path(&own).output();
    says(&said, 64, &["it is a recording, and nothing is written over one; name another file"]);
    let linked = named("linked", "png");
    fs::hard_link(&own, &linked).expect("a link");
    let said = Cullet::new(&["still"]).path(&own).args(&["-o"]).path(&linked).output();
    says(&said, 64, &["it is a recording, and nothing is written over one; name another file"]);
    assert!(fs::read(&own).expect("a recording") == bytes, "the recording is another one");
    // The same of other commands that read one file and write another.
    let folder = unique("preview");
    fs::create_dir_all(&folder).expect("a folder");
    fs::write(folder.join("preview.png"), &bytes).expect("a file");
    let said = Cullet::new(&["preview"]).path(&folder.join("preview.png")).output();
    says(&said, 64, &["it is a recording"]);
    for verb in ["report", "export", "still", "preview"] {
        let out = if verb == "preview" { folder.clone() } else { own.clone() };
        let said = Cullet::new(&[verb]).path(run).args(&["-o"]).path(&out).output();
        says(&said, 64, &["it is a recording"]);
    }
    let recording = folder.join("run.mcap");
    fs::write(&recording, &bytes).expect("a file");
    let said = Cullet::new(&["report"]).path(&folder).args(&["-o"]).path(&recording).output();
    says(&said, 64, &["it is a recording"]);
    let sets = ["--csv"];
    let bar = common::file_of("tests/specimens/e2-turn.toml");
    let said = Cullet::new(&["bench"]).path(&bar).args(&sets).path(&recording).output();
    says(&said, 64, &["it is a recording"]);
    assert!(fs::read(&recording).expect("a recording") == bytes, "the recording is another one");
    assert!(fs::read(&own).expect("a recording") == bytes, "the recording is another one");
    let specimen = named("bar", "toml");
    fs::copy(common::file_of("tests/specimens/e2-turn.toml"), &specimen).expect("a copy");
    let said = Cullet::new(&["bench"]).path(&specimen).args(&["--csv"]).path(&specimen).output();
    says(&said, 64, &["that is what is read"]);
}

/// A record of an MCAP file.
fn record(opcode: u8, body: &[u8]) -> Vec<u8> {
    [&[opcode], &(body.len() as u64).to_le_bytes()[..], body].concat()
}

#[test]
fn another_programs_mcap_is_no_run_and_damage_has_an_exit_code() {
    let _left = common::left::NobodyLeft::watch();
    let magic = b"\x89MCAP0\r\n";
    let text = |text: &str| [&(text.len() as u32).to_le_bytes()[..], text.as_bytes()].concat();
    let header = record(1, &[text(""), text("other 1.0")].concat());
    let whole = [&magic[..], &header, &record(15, &[0; 4]), &record(2, &[0; 20]), magic].concat();
    let other = named("other", "mcap");
    fs::write(&other, whole).expect("a file");
    for verb in ["inspect", "preview", "still", "recover", "export", "report"] {
        let said = Cullet::new(&[verb]).path(&other).output();
        says(&said, 64, &["is an MCAP file, but no recording of a run"]);
    }
    let good = fs::read(a_run().join("run.mcap")).expect("a recording");
    let damaged = |name: &str, bytes: &[u8]| {
        let file = unique("damaged").with_file_name(name);
        fs::write(&file, bytes).expect("a file");
        Cullet::new(&["inspect"]).path(&file).output()
    };
    let mut flipped = good.clone();
    flipped[good.len() / 3] ^= 1;
    for said in [
        damaged("beginning-flipped.mcap", &flipped),
        damaged("beginning-cut.mcap", &good[..good.len() / 2]),
    ] {
        says(&said, 1, &["cut off or damaged"]);
        assert!(said.stdout.contains("\"bodies_initial\": 3"), "what is sound is shown");
    }
    recovered_holes_stay(&flipped);
    // One that is still written, or was killed, has an end to come.
    says(&damaged("beginning.mcap.partial", &good[..good.len() / 2]), 0, &["cut off or damaged"]);
}

/// A recovered recording says what it lacks, to whoever reads it.
fn recovered_holes_stay(damaged: &[u8]) {
    let (from, folder) = (named("damaged", "mcap"), unique("recovered"));
    fs::write(&from, damaged).expect("a file");
    fs::create_dir_all(&folder).expect("a folder");
    let saved = folder.join("run.mcap");
    let said = Cullet::new(&["recover"]).path(&from).args(&["-o"]).path(&saved).output();
    says(&said, 0, &["it has holes: a part of the file is damaged; records are missing: "]);
    let said = Cullet::new(&["inspect"]).path(&saved).output();
    says(&said, 1, &["has holes: a part of the file is damaged; records are missing: "]);
    assert!(said.stdout.contains("\"missing\": \"a part of the file"), "{}", said.stdout);
    assert!(!said.stdout.contains("expected "), "{}", said.stdout);
    for (verb, file) in [("export", "x.glb"), ("report", "x.html"), ("still", "x.png")] {
        let call = Cullet::new(&[verb]).path(&folder).args(&["-o"]).path(&folder.join(file));
        let said = call.output();
        says(&said, 0, &["has holes"]);
        assert_eq!(said.stderr.matches("a part of the file is damaged").count(), 1, "{verb}");
    }
}

#[test]
fn what_is_no_regular_file_is_refused_and_not_waited_for() {
    let _left = common::left::NobodyLeft::watch();
    let folder = unique("pipes");
    fs::create_dir_all(&folder).expect("a folder");
    let pipe = |name: &str| {
        let path = folder.join(name);
        let made = Command::new("mkfifo").arg(&path).status();
        assert!(made.is_ok_and(|status| status.success()), "mkfifo {name}");
        path
    };
    let (scene, mesh, text) = (pipe("scene.toml"), pipe("m.obj"), pipe("text"));
    let set = format!("body.left.mesh=\"{}\"", mesh.display());
    let drop = corpus("drop.toml");
    let certs = folder.join("certs");
    common::certificates(&certs, &["coordinator"], &[]);
    let coordinator = Cullet::new(&["coordinator", "--listen", "tls/127.0.0.1:1", "--tls"]);
    let calls = [
        Cullet::new(&["check"]).path(&scene),
        Cullet::new(&["check"]).path(&folder),
        Cullet::new(&["check", &drop, "--set", &set]),
        Cullet::new(&["inspect"]).path(&text),
        Cullet::new(&["still"]).path(&text),
        Cullet::new(&["recover"]).path(&text),
        Cullet::new(&["bench"]).path(&scene),
        Cullet::new(&["job"]).path(&text),
        Cullet::new(&["frontier", "--redraw"]).path(&scene),
        coordinator.path(&certs.join("coordinator")).args(&["--roles"]).path(&text),
    ];
    for (index, call) in calls.into_iter().enumerate() {
        let mut going = call.spawn();
        let code = going.wait(Duration::from_secs(30));
        let said = going.stderr();
        assert!(matches!(code, Some(64 | 74)), "call {index}: {code:?} {said}");
        assert!(said.contains("no regular file"), "call {index}: {said}");
    }
}

#[test]
fn a_run_that_nobody_works_for_says_so_and_goes_on_when_somebody_does() {
    let _left = common::left::NobodyLeft::watch();
    let endpoint = common::free_endpoint();
    let log = unique("nobody");
    let _coordinator = Cullet::new(&["coordinator", "--listen", &endpoint]).spawn();
    let file = fs::File::create(&log).expect("a log");
    let out = unique("nobody-out");
    let call = ["submit", &corpus("drop.toml"), "--connect", &endpoint, "--out"];
    let mut submit = Cullet::new(&call).path(&out).errors(file).spawn();
    let said = || fs::read_to_string(&log).expect("a log");
    until("it says that nobody is there", LONG, || {
        assert!(!submit.ended(), "{}", said());
        said().contains("no worker is connected: ")
    });
    let mut lines: Vec<String> = said().lines().map(str::to_owned).collect();
    let count = lines.len();
    lines.dedup();
    assert_eq!(lines.len(), count, "a line is said twice in a row: {}", said());
    let _worker = Cullet::new(&["worker", "--connect", &endpoint]).spawn();
    assert_eq!(submit.wait(LONG), Some(0), "{}", said());
    assert!(said().contains("a worker is there, and the run goes on"), "{}", said());
}

#[test]
fn a_run_in_which_nothing_can_break_or_that_has_no_floor_says_so_at_its_start() {
    let _left = common::left::NobodyLeft::watch();
    let drop = corpus("drop.toml");
    let run = |sets: &[&str]| {
        let sets: Vec<&str> = sets.iter().flat_map(|set| ["--set", *set]).collect();
        let check = Cullet::new(&["check", &drop]).args(&sets).output();
        let out = unique("warned");
        let call = ["run", &drop, "--no-pictures", "--out"];
        let said = Cullet::new(&call).path(&out).args(&sets).output();
        assert!(common::DONE.contains(&said.code), "{}", said.stderr);
        (check.stdout, said.stderr)
    };
    let (check, said) = run(&["body.left.breakable=false", "body.right.material=steel"]);
    let line = "nothing in this scene can break: `right` is made of what does not break: steel; \
                `left` has `breakable = false`";
    assert!(check.contains(line) && said.contains(line), "{check}{said}");
    let (check, said) = run(&["body.floor.position=[9, 0, 0]"]);
    let line = "there is no floor under each of `left`, `right`";
    assert!(check.contains(line) && said.contains(line), "{check}{said}");
    let (check, said) = run(&["body.left.velocity=[0, 0, 0]", "body.right.velocity=[0, 0, 0]"]);
    assert!(!check.contains("warning"), "{check}");
    assert!(said.contains("nothing broke: "), "{said}");
}

#[test]
fn a_run_says_how_much_was_solved_and_how_much_was_sampled() {
    let _left = common::left::NobodyLeft::watch();
    let drop = corpus("drop.toml");
    let run = |sets: &[&str]| {
        let out = unique("shares");
        let sets: Vec<&str> = sets.iter().flat_map(|set| ["--set", *set]).collect();
        let call = ["run", &drop, "--no-pictures", "--out"];
        let said = Cullet::new(&call).path(&out).args(&sets).output();
        let inspect = Cullet::new(&["inspect"]).path(&out).output();
        (said, summary(&out)["shares"].clone(), inspect.stdout)
    };
    let most = "expect.sampled.max=0.2";
    let (said, shares, told) = run(&["fracture.solver=geometric", most]);
    assert_eq!(said.code, 3, "{}", said.stderr);
    assert!(said.stderr.contains("sampled must be at most 0.2; it was 1"), "{}", said.stderr);
    assert!(
        said.stderr.contains("(sampled: 100 % of pieces, 100 % of their mass)"),
        "{}",
        said.stderr
    );
    assert_eq!((&shares["sampled"], &shares["sampled_mass"]), (&1.0.into(), &1.0.into()));
    assert!(told.contains("at the end: 0 of ") && told.contains("; 0 solved, "), "{told}");
    let (said, shares, told) = run(&["fracture.max_particles=4000"]);
    assert_eq!(said.code, 0, "{}", said.stderr);
    let (pieces, sampled) = (shares["pieces"].as_u64(), shares["sampled_pieces"].as_u64());
    assert!(pieces > Some(2) && sampled < pieces, "a solve finds pieces: {shares}");
    let line = format!("{} sampled (", sampled.unwrap_or_default());
    assert!(told.contains(&line) && said.stderr.contains(&line), "{line}: {told}");
}
