//! Cuts whose faces show the grid (F22).

use super::{Cloud, DamageField, SETTINGS, assert_lawful, cube, extract};
use crate::pieces::Pieces;
use cullet_geometry::Vec3;
use cullet_model::strength::Region;

/// Pieces that are blocks of the grid show it however they are cut, and the cut says so (F22).
#[test]
fn a_cut_that_shows_the_grid_is_tried_again_and_told() {
    let cloud = Cloud::in_cube(0.08, |_| true);
    let block = |p: &Vec3| {
        let [x, y, z] = [p.x, p.y, p.z].map(|x| (3.0 * x) as u32);
        Some(x + 3 * y + 9 * z)
    };
    let of = cloud.positions.iter().map(block).collect();
    let pieces = Pieces { of, found: 27, ..Pieces::default() };
    let field = DamageField { pieces: Some(&pieces), ..cloud.field() };
    let cut = extract(&cube(), &field, &SETTINGS).unwrap();
    assert_lawful(&cut, 1.0, cloud.positions.len());
    assert!(cut.bias.shows() && cut.bias.times > 4.0, "{:?}", cut.bias);
    // Where the scene scored the body along its planes they are no sign of the grid.
    let scored: Vec<Region> = [1.0 / 3.0, 2.0 / 3.0]
        .iter()
        .flat_map(|&x| {
            (0..3).map(move |axis| {
                let ways = [Vec3::x(), Vec3::y(), Vec3::z()];
                let (along, inward) = (ways[(axis + 1) % 3], ways[(axis + 2) % 3]);
                let from = ways[axis] * x;
                Region::Groove { from, to: from + along, inward, half_width: 0.06 }
            })
        })
        .collect();
    let cut = extract(&cube(), &DamageField { scored: &scored, ..field }, &SETTINGS).unwrap();
    assert!(!cut.bias.shows() && cut.warnings.iter().all(|told| !told.contains("again")));
    // The same pieces askew to the grid show nothing, at the first attempt.
    let turn = cullet_geometry::Quat::from_euler_angles(0.5, 0.4, 0.3);
    let of = cloud.positions.iter().map(|p| block(&(turn * p).map(|x| x.rem_euclid(1.0))));
    let pieces = Pieces { of: of.collect(), found: 27, ..Pieces::default() };
    let field = DamageField { pieces: Some(&pieces), ..cloud.field() };
    let cut = extract(&cube(), &field, &SETTINGS).unwrap();
    assert!(!cut.bias.shows() && cut.warnings.iter().all(|told| !told.contains("again")));
}
