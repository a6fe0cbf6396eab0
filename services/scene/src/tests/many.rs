//! Scenes with very many errors: what they cost grows with their number, and no faster.

use super::super::format::Shape;
use super::super::geometry::{GeometryCache, GeometrySource};
use super::super::overlap::{Placed, overlaps, place};
use super::super::{load_bundle, load_bundle_until, resolve, schema};
use cullet_document::files::{Bundle, Files, SceneFile, Source};
use cullet_document::{check, document};
use cullet_geometry::{Pose, Vec3};
use std::cell::Cell;
use std::collections::BTreeMap;
use std::fmt::Write;
use std::sync::Arc;
use std::sync::atomic::{AtomicBool, Ordering};
use std::time::{Duration, Instant};

/// Items of each scene. If each cost a look at all others, loading would take minutes.
const MANY: usize = 20_000;

/// What that may take on a machine that has much else to do.
const BOUND: Duration = Duration::from_secs(20);

fn bundle(text: String) -> Bundle {
    let main = "scene/scene.toml".to_owned();
    let files = vec![SceneFile { key: main.clone(), bytes: Arc::new(text.into()) }];
    Bundle { name: "many".to_owned(), main, overrides: Vec::new(), files }
}

fn errors(text: String) -> (usize, String) {
    let begun = Instant::now();
    let errors = load_bundle(&bundle(text)).expect_err("it is full of errors");
    let said = errors.to_string();
    assert!(begun.elapsed() < BOUND, "{:?}: {said}", begun.elapsed());
    (errors.errors.len(), said)
}

fn body(n: usize, rest: &str) -> String {
    let shape = "shape = { kind = \"box\", size = [0.1, 0.1, 0.1] }";
    format!("[[body]]\nname = \"b{n}\"\nposition = [{n}, 0, 1]\n{shape}\n{rest}\n")
}

fn bodies(rest: &str) -> String {
    let all: String = (0..MANY).map(|n| body(n, rest)).collect();
    format!("[world]\nmax_bodies = {MANY}\n{all}")
}

#[test]
fn a_typo_in_each_of_many_bodies() {
    let (count, said) = errors(bodies("materiel = \"plaster\""));
    assert_eq!(count, MANY);
    assert!(said.contains("scene.toml:7:1: body.b0.materiel: unknown key `materiel`"), "{said}");
    assert!(said.ends_with(&format!("and {} more", MANY - 20)), "{said}");
    let (count, said) = errors(bodies("material = \"plastre\""));
    assert_eq!(count, MANY);
    assert!(said.contains("did you mean `plaster`?"), "{said}");
}

/// In one line, where each place is far from the line's start.
#[test]
fn a_typo_in_each_of_many_bodies_of_one_line() {
    let one = "{ name = \"b\", materiel = 1 }, ";
    let (count, said) = errors(format!("body = [{}]", one.repeat(MANY)));
    assert!(count >= MANY && said.len() < 20_000, "{count}: {}", said.len());
}

#[test]
fn many_joints_that_lack_what_they_join() {
    let joint = |n: usize| format!("[[joint]]\nkind = \"ball\"\nbodies = [\"b0\", \"b{n}\"]\n");
    let joints: String = (1..10_000).map(joint).collect();
    let (count, said) = errors(body(0, "material = \"plaster\"") + &joints);
    assert!(count >= 9_999, "{count}: {said}");
}

#[test]
fn many_joints_between_bodies_that_are_not_there() {
    let mut text = bodies("material = \"plaster\"");
    for n in 0..10_000 {
        let _written = write!(
            text,
            "[[joint]]\nkind = \"ball\"\nbetween = [\"c{n}\", \"b0\"]\nat = [0, 0, 0]\n"
        );
    }
    let (count, said) = errors(text);
    assert_eq!(count, 10_000);
    assert!(said.contains("there is no body \"c0\""), "{said}");
}

#[test]
fn glue_that_names_many_bodies_many_times() {
    let names = "\"all\", ".repeat(256);
    let one = |n| body(n, "material = \"plaster\"\ngroup = \"all\"");
    let group: String = (0..2_000).map(one).collect();
    let text = format!("{group}[[glue]]\nforce = 1\nbodies = [{names}]\n");
    let begun = Instant::now();
    let scene = load_bundle(&bundle(text)).unwrap_or_else(|errors| panic!("{errors}"));
    assert_eq!(scene.directions.glue[0].bodies.len(), 2_000);
    assert!(begun.elapsed() < BOUND, "{:?}", begun.elapsed());
}

#[test]
fn loading_ends_soon_once_nobody_wants_it() {
    let bundle = bundle(bodies("material = \"plaster\""));
    let said = load_bundle_until(&bundle, Arc::new(AtomicBool::new(true))).expect_err("stopped");
    assert_eq!(said.to_string(), "loading was stopped");
    // Of what is left to do after the text has been read nothing is done.
    assert_eq!(resolved_when_stopped(&bundle), (0, 0));
    // Bodies that all stand in one another, and a stop while that is found out.
    let (hulls, pose) = (vec![corners()], Pose::identity());
    let placed: Vec<Placed<'_>> = (0..1_000).map(|_| place(&hulls, &pose)).collect();
    let looks = Cell::new(0);
    let stopped = || {
        looks.set(looks.get() + 1);
        looks.get() > 3
    };
    let found = overlaps(&placed, usize::MAX, stopped, |_, _| false);
    assert_eq!((looks.get(), found.len()), (4, 999 + 998 + 997));
}

/// A form is not begun that nobody wants any more; one that is there costs nothing.
#[test]
fn no_form_is_made_once_nobody_wants_it() {
    let stop = Arc::new(AtomicBool::new(false));
    let mut files = Files::new(Source::Bundle(BTreeMap::new())).until(Arc::clone(&stop));
    let mut made = GeometryCache::default();
    let source = |size: f64| GeometrySource::Shape(Shape::Box { size: [size; 3] });
    assert!(made.get(&source(1.0), &mut files).is_ok());
    stop.store(true, Ordering::Relaxed);
    assert!(made.get(&source(1.0), &mut files).is_ok());
    let said = made.get(&source(2.0), &mut files).expect_err("stopped");
    assert_eq!(said, "loading was stopped");
}

/// How many bodies and errors a bundle comes to that is stopped once its text has been read.
fn resolved_when_stopped(bundle: &Bundle) -> (usize, usize) {
    let stop = Arc::new(AtomicBool::new(false));
    let of = |file: &SceneFile| (file.key.clone(), Arc::clone(&file.bytes));
    let source = Source::Bundle(bundle.files.iter().map(of).collect());
    let mut files = Files::new(source).until(Arc::clone(&stop));
    let (mut root, _) = document::read(&mut files, &bundle.main).expect("a document");
    let findings = check::check(schema::schema_json(), &mut root);
    stop.store(true, Ordering::Relaxed);
    let resolved = resolve::resolve(&root, findings, &mut files);
    (resolved.scene.bodies.len(), resolved.errors.len())
}

fn corners() -> Vec<Vec3> {
    let corner = |n: u8| Vec3::new(f64::from(n & 1), f64::from(n >> 1 & 1), f64::from(n >> 2));
    (0..8).map(corner).collect()
}
