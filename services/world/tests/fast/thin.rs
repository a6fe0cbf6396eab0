//! Thin bodies, thin fragments, and convex parts without thickness: none is a reason to stop.

use crate::common;

use common::*;
use cullet_geometry::{Quat, Solid, Vec3};
use cullet_world::{BodySpec, World};

/// Parts without thickness, or none at all, stand in for a body all the same: it lies on the floor.
#[test]
fn flat_parts_are_given_thickness() {
    let twice = |p: &Vec3| [*p, *p];
    let flat = |s: &mut BodySpec| s.hulls[0].iter_mut().for_each(|p| p.z = -0.05);
    let line = |s: &mut BodySpec| s.hulls[0].iter_mut().for_each(|p| (p.y, p.z) = (0.0, -0.05));
    let none = |s: &mut BodySpec| s.hulls[0] = vec![Vec3::zeros(); 9];
    let doubled = |s: &mut BodySpec| s.hulls[0] = s.hulls[0].iter().flat_map(twice).collect();
    let hair = |s: &mut BodySpec| s.hulls[0].iter_mut().for_each(|p| p.z = -0.05 + 1e-9 * p.z);
    let skewed = |s: &mut BodySpec| {
        let plane = s.hulls[0].iter().map(|p| Vec3::new(p.x, p.y, 0.3 * p.x + 0.7 * p.y));
        let plane: Vec<Vec3> = plane.collect();
        s.hulls.push(plane);
    };
    let changes: [&dyn Fn(&mut BodySpec); 6] = [&flat, &line, &none, &doubled, &hair, &skewed];
    for (k, change) in changes.into_iter().enumerate() {
        let mut world = World::new(settings()).expect("settings");
        put(&mut world, floor());
        let mut spec = body("cube", cuboid(Vec3::repeat(0.1)), GLASS, Vec3::new(0.0, 0.0, 0.06));
        change(&mut spec);
        let id = world.insert(spec).unwrap_or_else(|error| panic!("{k}: {error}"));
        for _ in 0..240 {
            world.step().unwrap_or_else(|error| panic!("{k}: {error}"));
        }
        let low = world.body(id).expect("there").pose.translation.vector.z;
        // On a line it tips over; without any part it would have fallen by 5 m.
        assert!(low > -0.2 && low < 0.08, "{k}: it fell to {low}");
    }
}

/// A sheet of a hundred nanometres and a hair of ten micrometres, turned, are bodies.
#[test]
fn sheets_and_hairs_are_bodies() {
    let turn = Quat::from_scaled_axis(Vec3::new(0.3, -1.1, 0.7));
    for size in [Vec3::new(1.0, 0.7, 1e-7), Vec3::new(1e-5, 1e-5, 10.0), Vec3::repeat(1e-4)] {
        let (mut solid, mut hulls) = cuboid(size);
        solid.mesh.vertices.iter_mut().for_each(|p| *p = turn * *p);
        hulls.iter_mut().flatten().for_each(|p| *p = turn * *p);
        let mut world = World::new(settings()).expect("settings");
        let spec = body("thin", (solid, hulls), GLASS, Vec3::new(0.0, 0.0, 20.0));
        let id = world.insert(spec).unwrap_or_else(|error| panic!("{size:?}: {error}"));
        steps(&mut world, 20);
        assert!(world.body(id).expect("there").spin.norm() < 1e-6);
    }
}

/// A slice of a nanometre off a block of 20 cm is a fragment, whatever its parts are.
#[test]
fn a_sliver_does_not_stop_a_break() {
    let turn = Quat::from_scaled_axis(Vec3::new(0.3, -1.1, 0.7));
    let level = [-0.1, -0.1 + 1e-9, 0.1];
    let side = |i: usize| 0.2 * i as f64 - 0.1;
    let place = |p: [usize; 3]| turn * Vec3::new(side(p[0]), side(p[1]), level[p[2]]);
    let grid = Grid { place: &place };
    let whole = (Solid::outer(grid.mesh([0; 3], [1, 1, 2])), grid.hulls([0; 3], [1, 1, 2]));
    for flat in [false, true] {
        let mut world = World::new(settings()).expect("settings");
        let id = put(&mut world, body("block", whole.clone(), GLASS, Vec3::zeros()));
        let mut pieces = vec![grid.piece([0, 0, 0], [1, 1, 1]), grid.piece([0, 0, 1], [1, 1, 2])];
        if flat {
            pieces[0].hulls = vec![vec![turn * Vec3::repeat(-0.1); 5]];
            pieces[1].hulls.push(vec![Vec3::zeros(); 2]);
        }
        let done = world.replace(id, &[], pieces, 0.0).unwrap_or_else(|error| panic!("{error}"));
        assert_eq!(done.fragments.len(), 2);
        steps(&mut world, 20);
    }
}
