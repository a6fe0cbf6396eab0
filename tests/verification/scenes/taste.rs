//! Fracture to taste: pieces that are asked for, guide points, parts that stay whole, scored lines,
//! and that all of it is told as directed.

use super::Shown;
use super::scored::{cracks, share};
use crate::common::{Cullet, summary};
use cullet_geometry::Vec3;
use cullet_geometry::inside::Nearest;
use cullet_record::{FragmentOrigin, Recording};

/// Places round the neck of a vase in the middle of its wall, in the body's frame \[m\]: its line
/// is 37 mm below the rim.
fn neck(recording: &Recording, id: u64) -> impl Iterator<Item = Vec3> {
    let body = recording.bodies.iter().find(|body| body.id == id).expect("a vase");
    let corners = recording.geometries[&body.geometry].vertices.chunks(3);
    let rim = corners.map(|x| x[2]).fold(f64::NEG_INFINITY, f64::max);
    (0..100).map(move |k| {
        let (sin, cos) = (f64::from(k) * std::f64::consts::TAU / 100.0).sin_cos();
        Vec3::new(0.0695 * cos, 0.0695 * sin, rim - 0.037)
    })
}

/// The pieces of two vases are as many as asked for; those of the third are as its solve found
/// them, which follows the line round its neck.
#[test]
fn vases() {
    let shown = Shown::of("vases");
    let (folder, told) = (&shown.folder, summary(&shown.folder));
    let recording = shown.recording();
    let id = |name: &str| {
        recording.bodies.iter().find(|body| body.name == name).expect("a vase of that name").id
    };
    let of = |name: &str| -> Vec<_> {
        recording.bodies.iter().filter(|body| body.parent == Some(id(name))).collect()
    };
    let [left, right, scored] = ["vase-left", "vase-right", "scored"].map(of);
    for pieces in [&left, &right] {
        assert!((20..=28).contains(&pieces.len()), "{} pieces", pieces.len());
    }
    let origins = recording.origins();
    let directed = |id: &u64| origins.get(id) == Some(&FragmentOrigin::Directed);
    let wanted = left.iter().chain(&right);
    let count = wanted.filter(|body| directed(&body.id)).count() as u64;
    assert!(count > 0 && told["directed"]["pieces"] == count, "{count} in {told:#}");
    assert!(told["shares"]["directed"]["pieces"].as_u64() <= Some(count), "{told:#}");
    assert!(!scored.iter().any(|body| directed(&body.id)));
    let (vase, surface) = (id("scored"), Nearest::new(&cracks(&recording, &scored)));
    let far: Vec<f64> = neck(&recording, vase).map(|x| surface.distance(x)).collect();
    let (cell, within) = (recording.spacings()[&vase], share(&far, recording.spacings()[&vase]));
    println!("{:.1} % of the neck within a cell of {:.1} mm", 100.0 * within, 1e3 * cell);
    assert!(within >= 0.9, "{cell} m: {far:?}");
    assert_eq!(told["directed"]["painted"], 3, "{told:#}");
    let area = |key: &str| told["directed"][key].as_f64().unwrap_or_default();
    assert!(area("added_crack_area") + area("closed_crack_area") > 0.0, "{told:#}");
    let look = recording.interiors()["vase-left"];
    assert_eq!((look.colour, look.roughness), ([0.72, 0.33, 0.2], 1.0));
    let said = Cullet::new(&["inspect"]).path(&folder.join("run.mcap")).output();
    assert!(said.stdout.contains(" directed"), "{}", said.stdout);
    let table = Cullet::new(&["inspect", "--masses"]).path(&folder.join("run.mcap")).output();
    assert!(table.stdout.contains(",directed,false\n"), "{}", table.stdout);
}
