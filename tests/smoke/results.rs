//! What a run leaves: pictures, a report, exports, a recording that is read; and one benchmark.

use crate::common;

use common::{Cullet, corpus, file_of, unique};
use std::fs;

#[test]
fn a_run_leaves_pictures_a_report_and_exports() {
    let out = unique("results");
    let run = Cullet::new(&["run", &corpus("drop.toml"), "-q", "--workers", "2", "--out"]);
    let said = run.path(&out).output();
    assert_eq!(said.code, 0, "{}", said.stderr);
    let png = fs::read(out.join("preview.png")).expect("a picture");
    assert_eq!(&png[1..4], b"PNG");
    for (command, ending, mark) in [
        ("export", "glb", "glTF"),
        ("export", "usda", "#usda"),
        ("export", "csv", ""),
        ("report", "html", "<!doctype html"),
    ] {
        let file = unique("results").with_extension(ending);
        let said = Cullet::new(&[command]).path(&out).args(&["-o"]).path(&file).output();
        assert_eq!(said.code, 0, "{command} {ending}: {}", said.stderr);
        if !mark.is_empty() {
            let bytes = fs::read(&file).expect("a file");
            let head = String::from_utf8_lossy(&bytes[..mark.len()]).to_lowercase();
            assert_eq!(head, mark.to_lowercase(), "{command} {ending}");
        }
    }
    let seen = Cullet::new(&["inspect"]).path(&out).output();
    assert!(seen.code == 0 && seen.stdout.contains("left"), "{}{}", seen.stdout, seen.stderr);
}

/// A wave in a bar is as fast as the formula says: the laboratory and the solver of solids.
#[test]
fn a_benchmark_holds() {
    let said = Cullet::new(&["bench", "-q"]).path(&file_of("tests/specimens/e3-bar-wave.toml"));
    let said = said.output();
    assert_eq!(said.code, 0, "{}{}", said.stdout, said.stderr);
}
