//! Sweeps, here and at a coordinator: handed in, broken off, fetched together, also later.

use crate::common;

use common::{Cullet, Going, corpus, file_of, unique, until};
use serde_json::Value;
use std::fs;
use std::path::{Path, PathBuf};
use std::time::Duration;

const LONG: Duration = Duration::from_secs(300);

/// A coordinator, with so many workers of its own, that runs one run at once.
struct Farm {
    endpoint: String,
    _process: Going,
}

impl Farm {
    fn start(workers: &str) -> Self {
        let endpoint = common::free_endpoint();
        let call = ["coordinator", "--listen", &endpoint, "--runs", "1", "--workers", workers];
        let process = Cullet::new(&call).args(&["--state"]).path(&unique("sweeping")).spawn();
        Self { endpoint, _process: process }
    }

    fn call(&self, args: &[&str]) -> Cullet {
        Cullet::new(args).args(&["--connect", &self.endpoint])
    }

    fn ask(&self, args: &[&str]) -> common::Said {
        self.call(args).output()
    }

    fn runs(&self) -> Vec<Value> {
        let said = self.ask(&["ps", "--json"]);
        assert_eq!(said.code, 0, "{}", said.stderr);
        let all: Value = serde_json::from_str(&said.stdout).expect("JSON");
        all["runs"].as_array().expect("a list").clone()
    }
}

/// A sweep of this text over the drop scene, in a folder of its own.
fn sweep(name: &str, text: &str) -> (PathBuf, PathBuf) {
    let folder = unique(name);
    fs::create_dir_all(&folder).expect("a folder");
    fs::copy(corpus("drop.toml"), folder.join("drop.toml")).expect("a scene");
    let file = folder.join("seeds.toml");
    fs::write(&file, format!("scene = \"drop.toml\"\n[product]\n{text}\n")).expect("a sweep");
    (folder, file)
}

/// The table of a sweep, by rows.
fn table(out: &Path) -> Vec<Vec<String>> {
    let text = fs::read_to_string(out.join("table.csv")).expect("a table");
    text.lines().map(|line| line.split(',').map(str::to_owned).collect()).collect()
}

/// The numbers that a call printed.
fn printed(said: &common::Said) -> Vec<u64> {
    said.stdout.lines().map(|line| line.parse().expect("a number")).collect()
}

#[test]
fn a_sweep_makes_a_table_and_a_sheet_here_and_at_a_coordinator() {
    let _left = common::left::NobodyLeft::watch();
    let folder = unique("sweep");
    fs::create_dir_all(&folder).expect("a folder");
    fs::copy(corpus("drop.toml"), folder.join("drop.toml")).expect("a scene");
    let text =
        "scene = \"drop.toml\"\n[product]\n\"world.seed\" = { from = 5, to = 6, step = 1 }\n";
    let file = folder.join("seeds.toml");
    fs::write(&file, text).expect("a sweep");
    let local = folder.join("local");
    let run = Cullet::new(&["run", "-q", "--no-pictures", "--out"]).path(&local).path(&file);
    let said = run.output();
    assert_eq!(said.code, 0, "{}", said.stderr);
    let farm = Farm::start("1");
    let far = folder.join("far");
    let submit = Cullet::new(&["submit", "-q", "--connect", &farm.endpoint, "--out"]);
    let said = submit.path(&far).args(&["--json"]).path(&file).output();
    assert_eq!(said.code, 0, "{}", said.stderr);
    let told: Vec<Value> =
        said.stdout.lines().map(|line| serde_json::from_str(line).expect("JSON")).collect();
    let of = |line: &Value| ["row", "run"].map(|key| line[key].clone());
    assert_eq!(told[0]["set"]["world.seed"], "5");
    assert_eq!(
        told.iter().map(of).collect::<Vec<_>>(),
        [[1, 1], [2, 2]].map(|pair| pair.map(Value::from))
    );
    let (here, there) = (table(&local), table(&far));
    assert_eq!(here.len(), 3, "{here:?}");
    assert_eq!(here[0][..3], ["row", "world.seed", "code"]);
    assert_eq!((here[1][1].as_str(), here[2][1].as_str()), ("5", "6"));
    let digests = |rows: &[Vec<String>]| -> Vec<Option<String>> {
        rows[1..].iter().map(|row| row.last().cloned()).collect()
    };
    assert_eq!(digests(&here), digests(&there));
    assert_eq!(told[1]["summary"]["digest"].as_str(), here[2].last().map(String::as_str));
    assert_ne!(here[1].last(), here[2].last(), "another seed is another run");
    for out in [&local, &far] {
        let sheet = fs::read(out.join("sheet.png")).expect("a sheet");
        assert!(sheet.starts_with(b"\x89PNG"));
    }
    assert_eq!(farm.runs()[1]["sweep"], "seeds");
    let bad = folder.join("bad.toml");
    fs::write(&bad, "scene = \"drop.toml\"\n[product]\n\"world.sed\" = [1]\n").expect("a sweep");
    for command in ["run", "check"] {
        let said = Cullet::new(&[command]).path(&bad).output();
        assert_eq!(said.code, 64);
        assert!(said.stderr.contains("sed=1") && said.stderr.contains("seed"), "{}", said.stderr);
    }
    let said = Cullet::new(&["check"]).path(&file).output();
    assert_eq!(said.code, 0, "{}", said.stderr);
    let lines: Vec<_> = said.stdout.lines().collect();
    assert_eq!((lines.len(), lines[0]), (3, "seeds: 2 runs"));
    assert!(lines[2].starts_with("  seed=6: drop, 3 bodies, "), "{}", lines[2]);
}

/// The page of a sweep has its table as it is in the file, and the picture of each of its runs.
#[test]
fn a_report_of_a_sweep_has_its_table_and_the_pictures_of_its_runs() {
    let _left = common::left::NobodyLeft::watch();
    let (folder, file) = sweep("reported", "\"world.duration\" = [0.01, 0.02, 0.03]");
    let out = folder.join("out");
    let run = Cullet::new(&["run", "-q", "--workers", "1", "--out"]).path(&out).path(&file);
    let said = run.args(&["--set", "fracture.max_particles=1000"]).output();
    assert!(said.code == 0 || said.code == 3, "{}: {}", said.code, said.stderr);
    // One of them has no picture.
    fs::remove_file(out.join("2/preview.png")).expect("its picture");
    let said = Cullet::new(&["report"]).path(&out).output();
    assert_eq!(said.code, 0, "{}", said.stderr);
    let page = fs::read_to_string(out.join("report.html")).expect("a page");
    let data = page.split_once("id=\"report\">").and_then(|(_, rest)| rest.split_once("</script>"));
    let data: Value = serde_json::from_str(data.expect("its data").0).expect("JSON");
    let rows = table(&out);
    assert_eq!((data["kind"].as_str(), rows.len()), (Some("sweep"), 4));
    assert_eq!(data["about"], "3 runs, 2 with a picture");
    assert_eq!(data["columns"], serde_json::json!(rows[0]));
    for (shown, cells) in data["rows"].as_array().expect("rows").iter().zip(&rows[1..]) {
        // What is set, and the digest, stand there as text; figures are numbers.
        for ((shown, cell), column) in
            shown.as_array().expect("cells").iter().zip(cells).zip(&rows[0])
        {
            let number = cell.parse::<f64>().ok();
            match &column[..] {
                "row" | "world.duration" | "digest" => assert_eq!(shown, cell),
                _ => assert_eq!(shown.as_f64(), number, "{column}"),
            }
        }
    }
    let pictures = data["pictures"].as_array().expect("pictures");
    let of = |picture: &Value| (picture["row"].as_u64(), picture["name"].clone());
    let name =
        |row: u64, value: &str| (Some(row), format!("row {}, world.duration {value}", row + 1));
    let named: Vec<_> = pictures.iter().map(of).collect();
    let wanted = [name(0, "0.01"), name(2, "0.03")].map(|(row, name)| (row, name.into()));
    assert_eq!(named, wanted);
    for picture in pictures {
        let file = out.join((picture["row"].as_u64().expect("a row") + 1).to_string());
        let bytes = fs::read(file.join("preview.png")).expect("a picture");
        let text = picture["png"].as_str().expect("text");
        assert!(text.starts_with("iVBORw0KGgo"), "base64 of the begin of a PNG");
        assert_eq!(text.len(), 4 * bytes.len().div_ceil(3));
    }
}

/// Who has left can have the sheet and the table all the same: of what is over, or of all.
#[test]
fn a_sweep_that_was_left_to_itself_is_fetched_together_later() {
    let _left = common::left::NobodyLeft::watch();
    let farm = Farm::start("1");
    let (folder, file) = sweep("later", "\"world.duration\" = [0.02, 600]");
    let set = ["--set", "fracture.max_particles=1000"];
    let said = farm.call(&["submit", "--detach"]).path(&file).args(&set).output();
    assert_eq!((said.code, said.stdout.as_str()), (0, "1\n2\n"), "{}", said.stderr);
    assert!(said.stderr.contains("cullet fetch") && said.stderr.contains("--follow"));
    let fetch = |out: &Path, more: &[&str]| {
        farm.call(&["fetch"]).path(&file).args(more).args(&["--out"]).path(out).output()
    };
    until("the second goes on", LONG, || farm.runs()[1]["state"] == "running");
    // The scene may have been changed since; what was handed in counts.
    fs::write(folder.join("drop.toml"), "nonsense").expect("a file");
    let (half, whole) = (folder.join("half"), folder.join("whole"));
    let said = fetch(&half, &set);
    assert_eq!(said.code, 75, "{}", said.stderr);
    assert!(said.stderr.contains("1 of 2 runs are not over"), "{}", said.stderr);
    let rows = table(&half);
    assert_eq!((rows[1][1].as_str(), rows[1][2].as_str()), ("0.02", "0"));
    assert_eq!((rows[2][1].as_str(), rows[2][2..].concat()), ("600", "2".into()), "its number");
    assert!(half.join("sheet.png").is_file() && half.join("1/run.mcap").is_file());
    // Somebody follows, and somebody ends it.
    let mut follows = farm.call(&["fetch", "--follow"]).path(&file).args(&set);
    follows = follows.args(&["--out"]).path(&whole);
    let mut follows = follows.spawn();
    assert_eq!(follows.wait(Duration::from_secs(1)), None, "it is not over");
    assert_eq!(farm.ask(&["cancel", "2"]).code, 0);
    assert_eq!(follows.wait(LONG), Some(5), "{}", follows.stderr());
    let rows = table(&whole);
    assert_eq!((rows[1][2].as_str(), rows[2][2].as_str()), ("0", "5"));
    assert_eq!(rows[1].last(), table(&half)[1].last());
    assert!(whole.join("sheet.png").is_file() && whole.join("2/run.mcap").is_file());
    // Nothing of the kind is there with other values, and not as a number.
    let said = fetch(&folder.join("none"), &[]);
    assert_eq!(said.code, 66, "{}", said.stderr);
    assert!(said.stderr.contains("--set as it was submitted"), "{}", said.stderr);
    assert!(!folder.join("none").exists());
    assert_eq!(farm.ask(&["fetch", "seven"]).code, 64);
    assert_eq!(farm.call(&["fetch"]).path(&folder.join("drop.toml")).output().code, 64);
}

/// What was broken off is handed in by halves and not doubled; a changed scene is another one.
#[test]
fn the_rest_of_a_sweep_is_what_is_not_there_yet() {
    let _left = common::left::NobodyLeft::watch();
    let farm = Farm::start("0");
    let (folder, file) = sweep("rest", "\"world.seed\" = [1, 2, 2, 3]");
    let submit = |more: &[&str]| {
        let said = farm.call(&["submit", "--detach"]).args(more).path(&file).output();
        assert_eq!(said.code, 0, "{}", said.stderr);
        printed(&said)
    };
    assert_eq!(submit(&["--rest"]), [1, 2, 3, 4], "nothing is there");
    assert_eq!(submit(&["--rest"]), [1, 2, 3, 4], "all is there");
    assert_eq!(farm.ask(&["cancel", "2"]).code + farm.ask(&["delete", "2"]).code, 0);
    assert_eq!(submit(&["--rest"]), [1, 5, 3, 4], "one is not");
    assert_eq!(farm.runs().len(), 4);
    assert_eq!(submit(&[]), [6, 7, 8, 9], "once more");
    assert_eq!(submit(&["--rest"]), [6, 7, 8, 9], "the newest");
    let scene = fs::read_to_string(corpus("drop.toml")).expect("a scene");
    fs::write(folder.join("drop.toml"), scene.replace("-16.0", "-15.0")).expect("a scene");
    assert_eq!(submit(&["--rest"]), [10, 11, 12, 13], "another scene");
    // Those of others are not one's own.
    assert_eq!(submit(&["--rest", "--user", "bob"]), [14, 15, 16, 17]);
    let said = farm.ask(&["submit", &corpus("drop.toml"), "--rest"]);
    assert_eq!(said.code, 64, "{}", said.stderr);
}

/// The runs of the load that is measured, all there at once. Nothing of them can be fetched before
/// the first is over, and then no folder is made.
#[test]
fn two_hundred_runs_wait_together_and_nothing_is_fetched_of_them_before_one_is_over() {
    let _left = common::left::NobodyLeft::watch();
    let farm = Farm::start("0");
    let file = file_of("tests/load/queue.toml");
    let said = farm.call(&["submit", "--detach"]).path(&file).output();
    assert_eq!(said.code, 0, "{}", said.stderr);
    assert_eq!(printed(&said), (1..=200).collect::<Vec<u64>>());
    let out = unique("nothing").join("below");
    let said = farm.call(&["fetch", "--json"]).path(&file).args(&["--out"]).path(&out).output();
    assert_eq!(said.code, 75, "{}", said.stderr);
    assert!(said.stderr.contains("200 of 200 runs are not over"), "{}", said.stderr);
    assert_eq!(said.stdout.lines().count(), 200, "{}", said.stdout);
    assert!(!out.parent().expect("a folder").exists(), "a folder is left");
    assert_eq!(farm.runs().iter().filter(|run| run["state"] == "queued").count(), 199);
}

/// More runs than may wait: who does not stay is told what is there and how to go on, who stays
/// waits for room. Nothing ends meanwhile, as there is no worker.
#[test]
fn a_sweep_larger_than_the_queue_waits_for_room_or_says_what_is_there() {
    let _left = common::left::NobodyLeft::watch();
    let farm = Farm::start("0");
    let (_, file) = sweep("large", "\"world.seed\" = { from = 1, to = 780, step = 1 }");
    until("it answers", LONG, || farm.ask(&["ps"]).code == 0);
    let leave = ["submit", "--detach", "--patience", "5"];
    let said = farm.call(&leave).path(&file).output();
    assert_eq!(said.code, 75, "{}", said.stderr);
    // One goes on, and as many wait as may.
    assert_eq!(printed(&said), (1..=769).collect::<Vec<u64>>());
    for words in ["is full", "769 of 780 runs are there", ": 1 to 769;", "--rest --detach"] {
        assert!(said.stderr.contains(words), "{words:?} is not in {}", said.stderr);
    }
    let one = farm.ask(&["submit", &corpus("drop.toml"), "--detach", "--patience", "3"]);
    assert_eq!(one.code, 75, "{}", one.stderr);
    let errors = unique("waits");
    let log = fs::File::create(&errors).expect("a file");
    let mut waits = farm.call(&["submit", "--rest"]).path(&file).errors(log).spawn();
    let said = || fs::read_to_string(&errors).expect("a log");
    until("it waits", LONG, || {
        said().contains("the queue there is full: drop waits for room in it")
    });
    assert_eq!(waits.wait(Duration::from_secs(2)), None, "it has left");
    assert_eq!(farm.runs().len(), 769);
    for run in 20..30 {
        assert_eq!(farm.ask(&["cancel", &run.to_string()]).code, 0);
    }
    until("ten more are there", LONG, || farm.runs().len() == 779);
    until("it says so", LONG, || said().contains("run 779: seed=779"));
    assert!(!said().contains("run 780"), "{}", said());
}
