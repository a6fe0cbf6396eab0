//! Cuts and tears.

use super::*;
use cullet_geometry::TriMesh;
use cullet_model::{BodyCut, MovingSurface, SurfaceFrame};

/// The drawn body at a frame.
fn drawn(outcome: &WindowOutcome, frame: &SurfaceFrame) -> TriMesh {
    let MovingSurface { triangles, .. } = &outcome.surfaces[frame.surface as usize];
    let place = |x: &[f32; 3]| frame.origin + Vec3::from(x.map(f64::from));
    TriMesh { vertices: frame.offsets.iter().map(place).collect(), triangles: triangles.clone() }
}

/// A cut through the middle of a block whose ends are drawn apart: no force, two closed halves.
#[test]
fn a_cut_block_comes_apart_without_force() {
    let bonds = BondedSolid { breaks: true, ..elastic() };
    let mut setup = block([0.12, 0.06, 0.06], 0.01, bonds);
    let slope = 0.3;
    let corner = |y: f64, z: f64| Vec3::new(0.003 + slope * z, y, z);
    let corners = vec![corner(-1.0, -1.0), corner(1.0, -1.0), corner(1.0, 1.0), corner(-1.0, 1.0)];
    let part = body(&mut setup);
    part.cuts = vec![BodyCut { corners }];
    let path = vec![(0.0, Vec3::zeros()), (0.05, Vec3::zeros()), (0.1, Vec3::new(0.04, 0.0, 0.0))];
    part.grips = vec![end_grip(-0.07, -0.045, vec![]), end_grip(0.045, 0.07, path)];
    part.damping = 0.1;
    let prepared = prepared(&setup);
    let end = solved(&prepared, None, window(0, 48, vec![])).unwrap();
    assert_eq!(end.pieces.len(), 2, "{:?}", end.pieces);
    assert_eq!(end.pieces[1].parent, 0);
    assert_eq!(end.ledger.torn_area, 0.0);
    let first = solved(&prepared, None, window(0, 1, vec![])).unwrap();
    let force = figure(&first, "grip_1_force_x").abs();
    assert!(force < 1e-9, "{force}");
    // The half that is not drawn feels nothing.
    assert!(figure(&end, "grip_1_force_x").abs() < 1e-9);
    for frame in [&end.frames[0], end.frames.last().unwrap()] {
        let mesh = drawn(&end, frame);
        let volume = mesh.signed_volume();
        assert!((volume / 4.32e-4 - 1.0).abs() < 0.02, "{volume}");
    }
    // Lips lie in the plane of the cut, and no triangle reaches from one half to the other.
    let mesh = drawn(&end, end.frames.last().unwrap());
    let longest = mesh.edges().into_iter().map(|edge| {
        let [a, b] = [edge.from, edge.to].map(|v| mesh.vertices[v as usize]);
        (a - b).norm()
    });
    let longest = longest.fold(0.0, f64::max);
    assert!(longest < 0.03, "{longest}");
    let halves = mesh.components();
    assert_eq!(halves.len(), 2);
    let open = mesh.open_edges().len();
    assert!(open == 0, "{open} open edges of {}", mesh.triangles.len());
    let area = mesh.area();
    let whole = 2.0 * (0.0072 + 0.0072 + 0.0036);
    let lips = 2.0 * 0.0036 * (1.0 + slope * slope).sqrt();
    assert!((area / (whole + lips) - 1.0).abs() < 0.03, "{area} of {}", whole + lips);
}

/// A notched bar is pulled in two: that takes no less than G by area, and not much more.
#[test]
fn a_notched_bar_tears_in_two() {
    let bonds = BondedSolid { breaks: true, ..elastic() };
    let mut setup = block([0.20, 0.06, 0.04], 0.0077, bonds);
    let part = body(&mut setup);
    part.material.fracture_energy = 20.0;
    part.damping = 0.2;
    let corner = |y: f64, z: f64| Vec3::new(0.001, y, z);
    let corners = vec![corner(0.0, -1.0), corner(1.0, -1.0), corner(1.0, 1.0), corner(0.0, 1.0)];
    part.cuts = vec![BodyCut { corners }];
    let path = vec![(0.0, Vec3::zeros()), (1.0, Vec3::new(0.12, 0.0, 0.0))];
    part.grips = vec![end_grip(-0.11, -0.09, vec![]), end_grip(0.09, 0.11, path)];
    let prepared = prepared(&setup);
    let (mut state, mut work, mut broken, mut step) = (None, 0.0, 0.0, 0);
    let end = loop {
        let end = solved(&prepared, state.as_deref(), window(step, 12, vec![])).unwrap();
        work += end.ledger.grips;
        broken += end.ledger.broken;
        let parted = end.pieces.iter().filter(|piece| piece.mass > 0.1 * end.ledger.mass).count();
        step += 12;
        if parted > 1 || step >= 240 {
            break end;
        }
        state = Some(end.state);
    };
    let large: Vec<_> =
        end.pieces.iter().filter(|piece| piece.mass > 0.1 * end.ledger.mass).collect();
    assert_eq!(large.len(), 2, "{:?}", end.pieces);
    let wanted = 20.0 * 0.03 * 0.04;
    println!(
        "tear: step {step}, s_c {:.3}, broken {broken:.4} J, work {work:.4} J of {wanted:.4}, \
         area {:.5} of 0.0012, pieces {}",
        figure(&end, "critical_stretch"),
        end.ledger.torn_area,
        end.pieces.len()
    );
    assert!(work >= wanted && broken >= 0.95 * wanted && broken <= 1.5 * wanted, "{broken}");
    assert!((end.ledger.torn_area / 0.0012 - 1.0).abs() < 0.5, "{}", end.ledger.torn_area);
    let mesh = drawn(&end, end.frames.last().unwrap());
    assert!(mesh.components().len() >= 2);
    let volume = mesh.signed_volume();
    assert!((volume / 4.8e-4 - 1.0).abs() < 0.1, "{volume}");
}

/// Half of a cut block is thrown away: twelve metres off it bears nothing, and nothing is lost.
#[test]
fn a_piece_that_flies_far_stays_as_it_is() {
    let mut setup = block([0.12, 0.06, 0.06], 0.01, BondedSolid { breaks: true, ..elastic() });
    let corner = |y: f64, z: f64| Vec3::new(0.001, y, z);
    let corners = vec![corner(-1.0, -1.0), corner(1.0, -1.0), corner(1.0, 1.0), corner(-1.0, 1.0)];
    body(&mut setup).cuts = vec![BodyCut { corners }];
    body(&mut setup).damping = 0.1;
    let prepared = prepared(&setup);
    let mut state = super::super::SoftSolidState::start(&prepared);
    let domain = &mut state.domain;
    for (v, at) in domain.velocities.iter_mut().zip(&prepared.rest) {
        if at.x > 0.001 {
            *v = Vec3::new(12.0, 0.0, 0.0) + Vec3::new(0.0, 2.0, 1.0).cross(at);
        }
    }
    let bytes = state.encode(&prepared);
    let end = solved(&prepared, Some(&bytes), window(0, 240, vec![])).unwrap();
    assert_eq!(end.pieces.len(), 2);
    let ledger = end.ledger;
    // What spins of the half is stretched by 1e-3 of its energy of spin.
    assert!(ledger.stretching < 1e-5, "{ledger:?}");
    assert!(ledger.residual.abs() < 1e-9 * ledger.kinetic, "{ledger:?}");
    let last = drawn(&end, end.frames.last().unwrap());
    assert!((last.signed_volume() / 4.32e-4 - 1.0).abs() < 0.01, "{}", last.signed_volume());
}
