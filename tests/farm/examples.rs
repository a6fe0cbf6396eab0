//! The programs in `services/cullet/examples`: each does its task once on a small scene, and what
//! it prints holds against what the others and `cullet` itself say.

use crate::common;

use common::{Cullet, file_of, summary, unique, until};
use std::path::{Path, PathBuf};
use std::process::Command;
use std::time::Duration;

const LONG: Duration = Duration::from_secs(300);
/// Density of the ball that breaks \[kg/m³\].
const PLASTER: f64 = 1150.0;

/// What an example prints.
fn example(name: &str, args: &[&str]) -> String {
    let folder = Path::new(env!("CARGO_BIN_EXE_cullet")).parent().expect("a folder");
    let program = folder.join("examples").join(name);
    assert!(program.exists(), "first: cargo build --release --workspace --examples");
    let said = Command::new(program).args(args).output().expect("an example starts");
    let errors = String::from_utf8_lossy(&said.stderr);
    assert!(said.status.success(), "{name} {args:?}: {errors}");
    String::from_utf8(said.stdout).expect("text")
}

/// A ball that falls onto a floor and breaks into sampled fragments, as a file in a folder.
fn scene(folder: &Path) -> String {
    std::fs::create_dir_all(folder).expect("a folder");
    let ball = std::fs::read_to_string(file_of("tests/corpus/ball.toml")).expect("a scene");
    let path = folder.join("ball.toml");
    std::fs::write(&path, ball + "[fracture]\nsolver = \"geometric\"\n").expect("a scene");
    path.to_string_lossy().into_owned()
}

/// The rows of a table without its head, which must be this.
fn rows(table: &str, head: &str) -> Vec<Vec<String>> {
    let mut lines = table.lines();
    assert_eq!(lines.next(), Some(head), "{table}");
    lines.map(|line| line.split(',').map(str::to_owned).collect()).collect()
}

fn number(text: &str) -> f64 {
    text.parse().unwrap_or_else(|_| panic!("{text} is no number"))
}

/// The numbers in the lines of an OBJ file that begin so.
fn lines(path: &Path, kind: &str) -> Vec<Vec<f64>> {
    let text = std::fs::read_to_string(path).expect("an OBJ file");
    let lines = text.lines().filter_map(|line| line.strip_prefix(kind));
    lines.map(|line| line.split_whitespace().map(number).collect()).collect()
}

/// The volume that the faces of an OBJ file enclose \[m³\].
fn volume(path: &Path) -> f64 {
    let (vertices, faces) = (lines(path, "v "), lines(path, "f "));
    let determinant = |face: &Vec<f64>| {
        let corner = |k: usize| &vertices[face[k] as usize - 1];
        let (a, b, c) = (corner(0), corner(1), corner(2));
        a[0] * (b[1] * c[2] - b[2] * c[1])
            + a[1] * (b[2] * c[0] - b[0] * c[2])
            + a[2] * (b[0] * c[1] - b[1] * c[0])
    };
    faces.iter().map(determinant).sum::<f64>() / 6.0
}

#[test]
fn a_run_in_the_process_of_a_program_is_that_of_the_command() {
    let _left = common::left::NobodyLeft::watch();
    let folder = unique("examples");
    let (scene, out) = (scene(&folder), folder.join("run"));
    let printed = example("run_scene", &[&scene, &out.to_string_lossy(), "world.seed=4"]);
    let printed: serde_json::Value = serde_json::from_str(&printed).expect("a summary");
    assert_eq!(printed, summary(&out));
    let there = folder.join("there");
    let call = ["run", &scene, "--set", "world.seed=4", "-q", "--no-pictures", "--out"];
    assert_eq!(Cullet::new(&call).path(&there).output().code, 0);
    assert_eq!(printed["digest"], summary(&there)["digest"]);
    assert_eq!(printed["fractures"], 1);
}

#[test]
fn a_wedge_breaks_into_more_the_faster_it_is() {
    let _left = common::left::NobodyLeft::watch();
    let folder = unique("wedge");
    let out = folder.join("runs").to_string_lossy().into_owned();
    let table = example("wedge", &[&scene(&folder), "ball", &out, "1", "8", "16"]);
    let rows = rows(&table, "speed_m_s,fragments,largest_kg,crack_energy_J,digest");
    let column = |k: usize| rows.iter().map(|row| number(&row[k])).collect::<Vec<_>>();
    assert_eq!(column(0), [1.0, 8.0, 16.0]);
    let (fragments, energy) = (column(1), column(3));
    assert!(fragments.is_sorted() && fragments[0] < fragments[2], "{table}");
    assert!(energy.is_sorted() && energy[2] > 0.0, "{table}");
    let digest = summary(&PathBuf::from(&out).join("8"))["digest"].clone();
    assert_eq!(digest, rows[1][4]);
}

#[test]
fn sizes_and_meshes_of_fragments_are_the_same_matter() {
    let _left = common::left::NobodyLeft::watch();
    let folder = unique("matter");
    let (scene, out) = (scene(&folder), folder.join("run"));
    let call = ["run", &scene, "-q", "--no-pictures", "--out"];
    assert_eq!(Cullet::new(&call).path(&out).output().code, 0);
    let recording = out.join("run.mcap").to_string_lossy().into_owned();
    let table = example("fragment_sizes", &[&recording]);
    let rows = rows(&table, "object,fragment,mass_kg,size_m,as_heavy,sampled");
    assert_eq!(rows.len() as u64, summary(&out)["fragments"].as_u64().expect("a count"));
    let column = |k: usize| rows.iter().map(|row| number(&row[k])).collect::<Vec<_>>();
    assert!(column(2).is_sorted_by(|a, b| a >= b), "the heaviest first: {table}");
    assert!(column(4).iter().zip(1..).all(|(count, k)| *count == f64::from(k)), "{table}");
    assert!(rows.iter().all(|row| row[0] == "ball" && row[5] == "true"), "{table}");
    let balls = column(3).iter().map(|d| std::f64::consts::PI / 6.0 * d.powi(3)).sum::<f64>();

    let meshes = folder.join("meshes").to_string_lossy().into_owned();
    let files = example("export_obj", &[&recording, "0.06", &meshes]);
    let fragments = files.lines().filter(|file| file.contains("-ball."));
    let enclosed = fragments.map(|file| volume(Path::new(file))).sum::<f64>();
    assert!((enclosed / balls - 1.0).abs() < 1e-9, "{enclosed} m³ of {balls} m³");
    let mass = column(2).iter().sum::<f64>();
    assert!((mass / (PLASTER * balls) - 1.0).abs() < 1e-9, "{mass} kg in {balls} m³");
    assert!(!files.lines().any(|file| file.ends_with("-ball.obj")), "it broke: {files}");
    // Before the impact there is the floor, and the ball where the scene puts it.
    let before = example("export_obj", &[&recording, "0", &meshes]);
    assert_eq!(before.lines().count(), 2, "{before}");
    let ball = before.lines().find(|file| file.ends_with("-ball.obj")).expect("the ball");
    let heights: Vec<f64> = lines(Path::new(ball), "v ").iter().map(|vertex| vertex[2]).collect();
    let ends =
        heights.iter().fold([f64::MAX, f64::MIN], |[low, high], z| [low.min(*z), high.max(*z)]);
    assert!((0.5 * (ends[0] + ends[1]) - 0.16).abs() < 1e-6, "from {} to {} m", ends[0], ends[1]);
}

#[test]
fn a_scene_that_a_program_submits_comes_back_as_its_recording() {
    let _left = common::left::NobodyLeft::watch();
    let folder = unique("submitted");
    let (scene, out) = (scene(&folder), folder.join("fetched"));
    let endpoint = common::free_endpoint();
    let call = ["coordinator", "--listen", &endpoint, "--workers", "1", "--state"];
    let _coordinator = Cullet::new(&call).path(&folder.join("state")).spawn();
    let ask = || Cullet::new(&["ps", "-q", "--connect", &endpoint]).output().code == 0;
    until("it is there", LONG, ask);
    let printed = example("submit", &[&endpoint, &scene, &out.to_string_lossy()]);
    let printed: serde_json::Value = serde_json::from_str(&printed).expect("a summary");
    assert_eq!(printed, summary(&out));
    assert_eq!(printed["fractures"], 1);
}
