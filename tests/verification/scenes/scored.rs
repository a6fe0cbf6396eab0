//! Cracks keep to scored lines, in each family that breaks brittle bodies.

use crate::common::{Cullet, corpus, unique};
use cullet_geometry::inside::Nearest;
use cullet_geometry::{Solid, Surface, TriMesh, Vec3};
use cullet_proto::recording::Body;
use cullet_record::Recording;

/// Places along a line that are looked at, without its ends.
const PLACES: usize = 60;
/// Depths at which, over the thickness \[1\].
const DEPTHS: [f64; 3] = [0.1, 0.5, 0.9];

/// The crack faces of pieces, where these were in the whole body that they broke from.
pub(super) fn cracks(recording: &Recording, pieces: &[&Body]) -> TriMesh {
    let places = recording.rest_places();
    let mut cracks = TriMesh::default();
    for body in pieces {
        let solid = Solid::try_from(&recording.geometries[&body.geometry]).expect("a solid");
        for (t, _) in solid.surface.iter().enumerate().filter(|(_, s)| **s != Surface::Outer) {
            let first = cracks.vertices.len() as u32;
            let corners = solid.mesh.corners(t).map(|x| x + places[&body.id].origin);
            cracks.vertices.extend(corners);
            cracks.triangles.push([first, first + 1, first + 2]);
        }
    }
    cracks
}

/// Distances from places below a line to the nearest crack \[m\], sorted, and the spacing of the
/// solve \[m\], zero where there was none.
fn distances(scene: &str, sets: &[&str], [from, to]: [Vec3; 2], deep: f64) -> (Vec<f64>, f64) {
    let folder = unique(scene);
    let sets = sets.iter().flat_map(|set| ["--set", set]);
    let run = Cullet::new(&["run", "-q", "--no-pictures", &corpus(scene), "--out"]).path(&folder);
    let run = run.args(&sets.collect::<Vec<_>>()).output();
    assert_eq!(run.code, 0, "{scene}: {}", run.stderr);
    let recording = Recording::open(&folder.join("run.mcap")).expect("a recording");
    let pieces = recording.bodies.iter().filter(|body| body.parent.is_some());
    let surface = Nearest::new(&cracks(&recording, &pieces.collect::<Vec<_>>()));
    let at = |k: usize| from + (to - from) * ((k as f64 + 2.5) / (PLACES as f64 + 4.0));
    let below = |depth: f64| (0..PLACES).map(move |k| at(k) - Vec3::z() * (depth * deep));
    let distances: Vec<f64> =
        DEPTHS.into_iter().flat_map(below).map(|x| surface.distance(x)).collect();
    let broken = recording.bodies.iter().find(|body| body.parent.is_some()).expect("a fragment");
    let spacing = recording.spacings()[&broken.parent.expect("what broke")];
    let mut sorted = distances;
    sorted.sort_by(f64::total_cmp);
    let [middle, ninth] = [0.5, 0.9].map(|q| 1e3 * sorted[(q * sorted.len() as f64) as usize]);
    print!("{scene}: {middle:.2} mm in the median, {ninth:.2} mm for nine of ten");
    match spacing > 0.0 {
        true => {
            let (cell, within) = (1e3 * spacing, 100.0 * share(&sorted, spacing));
            println!(", {within:.1} % of the line within a cell of {cell:.1} mm");
        }
        false => println!(),
    }
    (sorted, spacing)
}

/// The share of places from which a crack is no farther than `most` \[m\].
pub(super) fn share(distances: &[f64], most: f64) -> f64 {
    distances.iter().filter(|far| **far <= most).count() as f64 / distances.len() as f64
}

const TILE: [Vec3; 2] = [Vec3::new(0.05, -0.1, 0.012), Vec3::new(0.08, 0.1, 0.012)];

/// A solid's crack lies within a cell of the line; without the line hardly any does.
#[test]
fn a_scored_tile_breaks_along_its_line() {
    let (far, cell) = distances("scored.toml", &[], TILE, 0.024);
    assert!(cell > 0.0 && share(&far, cell) >= 0.9, "{cell} m: {far:?}");
    let (far, cell) = distances("scored.toml", &["body.tile.paint.0.factor=1"], TILE, 0.024);
    assert!(share(&far, cell) < 0.6, "{cell} m: {far:?}");
}

/// Where pieces are sampled, cracks lie on the line but for their relief.
#[test]
fn sampled_cells_end_at_the_line() {
    let far = |sets: &[&str]| distances("scored.toml", sets, TILE, 0.024);
    let (scored, spacing) = far(&["fracture.solver=geometric"]);
    assert!(spacing == 0.0 && share(&scored, 2e-3) >= 0.99, "{scored:?}");
    let (without, _) = far(&["fracture.solver=geometric", "body.tile.paint.0.factor=1"]);
    assert!(share(&without, 2e-3) < 0.3, "{without:?}");
}

/// A cutter's score in a thin pane: the shell's crack runs along it.
#[test]
fn a_scored_pane_breaks_along_its_line() {
    let line = [Vec3::new(0.03, -0.12, 0.0025), Vec3::new(0.07, 0.12, 0.0025)];
    let along = ["world.seed=1", "world.seed=2", "world.seed=3"].map(|seed| {
        let (far, cell) = distances("scored-pane.toml", &[seed], line, 0.005);
        assert!(cell > 0.0);
        share(&far, cell)
    });
    // In one of several the crack leaves the line for a while.
    assert!(along.iter().all(|share| *share >= 0.8), "{along:?}");
    assert!(along.iter().sum::<f64>() >= 3.0 * 0.95, "{along:?}");
    let (far, cell) = distances("scored-pane.toml", &["body.pane.paint.0.factor=1"], line, 0.005);
    assert!(share(&far, cell) < 0.6, "{cell} m: {far:?}");
}
