//! Fragments come into the world quietly (F34), or not at all.

use crate::common;

use common::*;
use cullet_geometry::{Solid, Vec3};
use cullet_model::Fragment;
use cullet_world::{BodyId, ReplaceError, World, WorldSettings};

#[test]
fn birth_is_quiet() {
    let shell_place = |p: [usize; 3]| {
        let half = std::f64::consts::FRAC_PI_2;
        let (st, ct) = libm::sincos(half * (0.15 + 0.7 * p[0] as f64 / 4.0 * 2.0));
        let (sp, cp) = libm::sincos(half * p[1] as f64 / 2.0);
        Vec3::new(st * cp, st * sp, ct) * (0.1 + 0.01 * p[2] as f64)
    };
    let ring = Grid { place: &shell_place };
    let shell: Vec<Fragment> = (0..2)
        .flat_map(|i| (0..4).map(move |j| (i, j)))
        .map(|(i, j)| ring.piece([2 * i, 2 * j, 0], [2 * i + 2, 2 * j + 2, 1]))
        .collect();
    let mut shell_solid = cullet_geometry::TriMesh::default();
    for piece in &shell {
        let base = shell_solid.vertices.len() as u32;
        shell_solid.vertices.extend(&piece.solid.mesh.vertices);
        shell_solid
            .triangles
            .extend(piece.solid.mesh.triangles.iter().map(|t| t.map(|i| i + base)));
    }
    let cases = [
        ("octants", cuboid(CUBE).0, cells(CUBE, 2, 0.0)),
        ("jagged", cuboid(CUBE).0, cells(CUBE, 4, 0.45)),
        ("shell", Solid::outer(shell_solid), shell),
    ];
    for (name, solid, pieces) in cases {
        let (solid, pieces) = centred(solid, pieces);
        let mut world = World::new(weightless()).unwrap();
        let hulls = pieces.iter().flat_map(|p| p.hulls.clone()).collect();
        let id = put(&mut world, body(name, (solid, hulls), GLASS, Vec3::zeros()));
        world.replace(id, &[], pieces, 0.0).unwrap();
        let mut fastest = 0.0f64;
        for _ in 0..60 {
            world.step().unwrap();
            fastest = world.bodies().map(|b| b.velocity.norm()).fold(fastest, f64::max);
        }
        assert!(fastest < 0.05, "{name}: a fragment reached {fastest} m/s");
        let energy = world.totals().kinetic_energy;
        assert!(energy < 1e-3 * 0.5 * world.totals().mass, "{name}: {energy} J out of nothing");
    }
}

/// Moves a solid and its pieces to their centre of mass.
fn centred(mut solid: Solid, mut pieces: Vec<Fragment>) -> (Solid, Vec<Fragment>) {
    let (mut volume, mut first) = (0.0, Vec3::zeros());
    for t in 0..solid.mesh.triangles.len() {
        let [a, b, c] = solid.mesh.corners(t);
        let v = a.dot(&b.cross(&c)) / 6.0;
        volume += v;
        first += (a + b + c) * (v / 4.0);
    }
    let centre = first / volume;
    let shift = |points: &mut Vec<Vec3>| points.iter_mut().for_each(|p| *p -= centre);
    shift(&mut solid.mesh.vertices);
    for piece in &mut pieces {
        shift(&mut piece.solid.mesh.vertices);
        piece.hulls.iter_mut().for_each(shift);
    }
    (solid, pieces)
}

#[test]
fn bad_replacements_are_refused_and_change_nothing() {
    let mut world = World::new(WorldSettings { max_bodies: 8, ..weightless() }).unwrap();
    let id = put(&mut world, body("cube", cuboid(CUBE), GLASS, Vec3::zeros()));
    let before = bits(&world);
    let refuse = |world: &mut World, id, pieces| world.replace(id, &[], pieces, 0.0).unwrap_err();
    assert!(matches!(
        refuse(&mut world, BodyId(99), cells(CUBE, 2, 0.0)),
        ReplaceError::Unknown(_)
    ));
    assert!(matches!(refuse(&mut world, id, cells(CUBE, 1, 0.0)), ReplaceError::TooFew(1)));
    assert!(matches!(
        refuse(&mut world, id, cells(CUBE, 3, 0.0)),
        ReplaceError::Budget { count: 27, .. }
    ));
    let mut lossy = cells(CUBE, 2, 0.0);
    lossy.pop();
    assert!(matches!(refuse(&mut world, id, lossy), ReplaceError::Volume { .. }));
    let mut nan = cells(CUBE, 2, 0.0);
    nan[3].velocity.x = f64::NAN;
    assert!(matches!(refuse(&mut world, id, nan), ReplaceError::Piece { index: 3, .. }));
    let mut turned = cells(CUBE, 2, 0.0);
    turned[1].solid.mesh.triangles.iter_mut().for_each(|t| t.swap(0, 1));
    assert!(matches!(refuse(&mut world, id, turned), ReplaceError::Piece { index: 1, .. }));
    assert!(matches!(
        world.replace(id, &[], cells(CUBE, 2, 0.0), 1.0),
        Err(ReplaceError::Unaffordable { .. })
    ));
    assert_eq!(bits(&world), before);
    world.replace(id, &[], cells(CUBE, 2, 0.0), 0.0).unwrap();
}
