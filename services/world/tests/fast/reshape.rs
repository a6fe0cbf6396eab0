//! A body is dented: it stays the body that it is, and the books balance.

use crate::common;

use common::*;
use cullet_geometry::{Solid, Vec3};
use cullet_world::{BodyId, BodySpec, Hit, ReplaceError, Reshape, World};

/// The cube pressed flat by a tenth along z and no wider for it: a tenth of its volume goes. It
/// takes the whole impulse of the hit, and the work.
fn pressed(world: &World, cube: BodyId, hit: &Hit, work: f64) -> Reshape {
    let view = world.body(cube).expect("the cube");
    let mut mesh = view.solid.mesh.clone();
    mesh.vertices.iter_mut().for_each(|p| *p = Vec3::new(p.x, p.y, 0.9 * p.z + 0.003));
    let hulls = vec![mesh.vertices.clone()];
    let velocity = hit.impact.normal * (hit.impact.impulse / view.mass);
    let (solid, spin) = (Solid::outer(mesh), Vec3::zeros());
    Reshape { solid, hulls, velocity, spin, reactions: Vec::new(), work }
}

#[test]
fn a_dent_keeps_mass_and_momentum_and_is_paid_for() {
    for case in 0..20 {
        let (mut world, cube, _, hits) = strike(case);
        let (before, old) = (world.totals(), world.body(cube).expect("the cube").mass);
        let work = 0.2 * hits[0].impact.energy;
        let new = pressed(&world, cube, &hits[0], work);
        let done = world.reshape(cube, &hits, new.clone()).expect("a dent");
        let (after, view) = (world.totals(), world.body(cube).expect("the cube is there still"));
        assert_eq!((done.fragments.as_slice(), view.mass), ([cube].as_slice(), old), "{case}");
        assert!((done.volume_rel_error - 0.1).abs() < 1e-12, "{case}: {done:?}");
        assert!((view.density / (old / view.volume) - 1.0).abs() < 1e-12);
        assert_eq!((view.generation, view.parent, view.breakable), (0, None, true));
        assert!(done.momentum_rel_error < 1e-12, "{case}: {done:?}");
        assert!(done.angular_momentum_rel_error < 1e-12, "{case}: {done:?}");
        let scale = before.mass * 15.0;
        assert!((after.momentum - before.momentum).norm() < 1e-12 * scale, "{case}");
        assert!(done.energy_gain_rel < 1e-12, "{case}: {done:?}");
        assert!(done.energy_after + work <= done.energy_before * (1.0 + 1e-12), "{case}");
        // The shape is the solver's, bit for bit, moved to its centre of mass.
        let centre = new.solid.mesh.mass_properties().centroid;
        let moved = new.solid.mesh.vertices.iter().map(|p| p - centre);
        assert!(moved.eq(view.solid.mesh.vertices.iter().copied()), "{case}");
        steps(&mut world, 10);
    }
}

#[test]
fn what_cannot_be_paid_or_is_no_shape_changes_nothing() {
    let (mut world, cube, _, hits) = strike(3);
    let before = bits(&world);
    let good = pressed(&world, cube, &hits[0], 0.0);
    let mut refused = |new: Reshape| world.reshape(cube, &hits, new).expect_err("refused");
    let dear = refused(Reshape { work: 1e6, ..good.clone() });
    assert!(matches!(dear, ReplaceError::Unaffordable { .. }), "{dear}");
    let mut inside_out = good.clone();
    inside_out.solid.mesh.triangles.iter_mut().for_each(|t| t.swap(0, 1));
    assert!(matches!(refused(inside_out), ReplaceError::Piece { .. }));
    let nan = Reshape { velocity: Vec3::repeat(f64::NAN), ..good.clone() };
    assert!(matches!(refused(nan), ReplaceError::Piece { .. }));
    let nan = Reshape { work: f64::NAN, ..good.clone() };
    assert!(matches!(refused(nan), ReplaceError::Piece { .. }));
    assert_eq!(bits(&world), before);
    let gone = world.reshape(BodyId(99), &hits, good).expect_err("no such body");
    assert!(matches!(gone, ReplaceError::Unknown(_)));
}

#[test]
fn pieces_of_a_dented_body_have_its_mass() {
    let (mut world, cube, _, hits) = strike(5);
    let mass = world.body(cube).expect("the cube").mass;
    let new = pressed(&world, cube, &hits[0], 0.0);
    world.reshape(cube, &hits, new).expect("a dent");
    let size = Vec3::new(CUBE.x, CUBE.y, 0.9 * CUBE.z);
    let done = world.replace(cube, &[], cells(size, 3, 0.3), 0.0).expect("it breaks");
    assert!(done.mass_rel_error < 1e-12, "{done:?}");
    let parts = done.fragments.iter().filter_map(|&id| world.body(id));
    let sum: f64 = parts.map(|part| part.mass).sum();
    assert!((sum / mass - 1.0).abs() < 1e-12, "{sum} kg of {mass}");
}

#[test]
fn a_body_that_never_moves_keeps_its_place() {
    let mut world = World::new(weightless()).expect("a world");
    let wall = body("wall", cuboid(CUBE), GLASS, Vec3::zeros());
    let wall = put(&mut world, BodySpec { fixed: true, ..wall });
    let ball = body("ball", sphere(0.03, 6), STEEL, Vec3::new(0.0, 0.0, 0.3));
    put(&mut world, BodySpec { velocity: Vec3::new(0.0, 0.0, -9.0), breakable: false, ..ball });
    let hits: Vec<Hit> =
        until_hit(&mut world, 60).into_iter().filter(|hit| hit.body == wall).collect();
    let new = pressed(&world, wall, &hits[0], 0.1 * hits[0].dissipated);
    world.reshape(wall, &hits, new.clone()).expect("a dent");
    let view = world.body(wall).expect("the wall");
    assert!(view.fixed && view.velocity == Vec3::zeros());
    assert!((view.solid.mesh.mass_properties().volume / (0.9 * 0.008) - 1.0).abs() < 1e-12);
    // What the solver left as it was has not moved: the shape lies where it was drawn.
    let there = |p: &Vec3| (view.pose * nalgebra::Point3::from(*p)).coords;
    let drawn = view.solid.mesh.vertices.iter().zip(&new.solid.mesh.vertices);
    assert!(drawn.into_iter().all(|(p, q)| (there(p) - q).norm() < 1e-12), "{}", view.pose);
    let dear = Reshape { work: 10.0 * hits[0].dissipated, ..new };
    assert!(matches!(world.reshape(wall, &hits, dear), Err(ReplaceError::Unaffordable { .. })));
}
