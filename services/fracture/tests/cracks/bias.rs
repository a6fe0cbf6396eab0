//! F22: what the grid's directions do to cracks. The cube of mode I turned against the grid, and
//! the directions in which a body falls apart that nothing else directs.

use super::specimen::{H, Points, STONE, Specimen};
use cullet_fracture::mpm::domain::Fields;
use cullet_fracture::mpm::{Domain, quadrature};
use cullet_fracture::particles::Particles;
use cullet_fracture::strength::{Strength, StrengthField};
use cullet_geometry::{Mat3, Quat, Vec3, inside::Inside, sample, shapes};
use rayon::prelude::*;

/// Half the edge of the cube, in spacings.
const HALF: f64 = 6.0;

/// What a crack came to.
#[derive(Clone, Copy, Debug)]
struct Crack {
    /// Between its mean plane and the cube's \[degree\].
    tilt: f64,
    /// Root mean square of the distance of broken points from its mean plane, in spacings.
    rough: f64,
    /// Energy that went into damage over G_f times the section \[1\].
    spent: f64,
    layers: f64,
}

fn crack(turn: Quat, points: Points) -> Crack {
    let specimen = Specimen { turn, points, ..Specimen::straight(HALF, 0) };
    let mut domain = specimen.domain(Vec3::new(0.0, 0.01, 0.0), Fields::Split);
    let mut spent = 0.0;
    while domain.steps < 360 {
        spent += domain.advance().dissipated;
    }
    let broken = specimen.broken(&domain.particles);
    // Least squares for y = a + b x + c z.
    let (mut matrix, mut right) = (Mat3::zeros(), Vec3::zeros());
    let ahead: Vec<&Vec3> = broken.iter().filter(|x| x.x > 1.0).collect();
    for x in &ahead {
        let row = Vec3::new(1.0, x.x, x.z);
        matrix += row * row.transpose();
        right += row * x.y;
    }
    let fit = matrix.try_inverse().expect("points") * right;
    let off = ahead.iter().map(|x| (x.y - fit.dot(&Vec3::new(1.0, x.x, x.z))).powi(2));
    Crack {
        tilt: libm::atan(fit.y.hypot(fit.z)).to_degrees(),
        rough: (off.sum::<f64>() / ahead.len() as f64).sqrt(),
        spent: spent / (STONE.fracture_energy * specimen.section()),
        layers: specimen.layers(&broken),
    }
}

#[test]
fn a_crack_keeps_its_plane_however_the_grid_lies() {
    let about = |axis: Vec3, degrees: f64| Quat::from_scaled_axis(axis * degrees.to_radians());
    let mut turns: Vec<(String, Quat)> = [0.0, 11.25, 22.5, 33.75, 45.0]
        .map(|degrees| (format!("{degrees}° about the front"), about(Vec3::z(), degrees)))
        .to_vec();
    turns.push(("40° about (1, 2, 3)".into(), about(Vec3::new(1.0, 2.0, 3.0).normalize(), 40.0)));
    let kinds = [Points::Poisson(3), Points::Poisson(4), Points::Lattice];
    let pairs: Vec<(usize, Points)> =
        (0..turns.len()).flat_map(|turn| kinds.map(|kind| (turn, kind))).collect();
    let cracks: Vec<Crack> =
        pairs.par_iter().map(|&(turn, kind)| crack(turns[turn].1, kind)).collect();
    for ((turn, kind), crack) in pairs.iter().zip(&cracks) {
        println!("| {} | {kind:?} | {crack:.3?} |", turns[*turn].0);
    }
}

/// A ball that grows evenly until it falls apart: the normals of its broken points.
fn normals(points: Points) -> Vec<Vec3> {
    let radius = 9.0 * H;
    let seed = if let Points::Poisson(seed) = points { seed } else { 3 };
    let mesh = shapes::sphere(radius, shapes::Detail::default()).expect("a ball");
    let inside = Inside::new(&mesh);
    let laid = match points {
        Points::Poisson(seed) => sample::poisson(&inside, 0.5 * H, seed).expect("points"),
        Points::Lattice => Points::lattice(&inside, 24),
    };
    let volume = mesh.signed_volume();
    let mut particles = Particles::at_rest(&laid, volume, STONE.density);
    particles.volume = quadrature::volumes(&laid, &inside, Vec3::repeat(H), volume);
    let field = StrengthField { seed, weibull: 10.0, ..StrengthField::default() };
    let strength = Strength::new(&field, H);
    for (own, x) in particles.strength.iter_mut().zip(&laid) {
        *own = strength.factor(x);
    }
    let mut domain = Domain::new(particles, &STONE, Specimen::law(), Vec3::repeat(H));
    domain.launch(|x| x * 4.0);
    while domain.steps < 200 {
        domain.advance();
    }
    let broken = domain.particles.normal.iter().zip(&domain.particles.damage);
    broken.filter(|(_, damage)| **damage >= 1.0).map(|(n, _)| *n).collect()
}

/// Shares of directions within 15 degrees of the grid's axes, of the diagonals of its faces and
/// of its cells, over those of directions that are all alike likely.
fn peaks(normals: &[Vec3]) -> [f64; 3] {
    let near = 15_f64.to_radians();
    let sets: [Vec<Vec3>; 3] = [1, 2, 3].map(|wanted| {
        let all = (0..27).map(|k| Vec3::new((k / 9 - 1) as f64, (k / 3 % 3 - 1) as f64, (k % 3 - 1) as f64));
        all.filter(|d| d.norm_squared() as i32 == wanted).map(|d| d.normalize()).collect()
    });
    sets.map(|set| {
        let even = set.len() as f64 * 0.5 * (1.0 - libm::cos(near));
        let found = normals.iter().filter(|n| set.iter().any(|d| n.dot(d) > libm::cos(near)));
        found.count() as f64 / normals.len() as f64 / even
    })
}

#[test]
fn a_body_falls_apart_in_all_directions() {
    let kinds: Vec<Points> = (0..4).map(Points::Poisson).chain([Points::Lattice]).collect();
    let all: Vec<Vec<Vec3>> = kinds.par_iter().map(|kind| normals(*kind)).collect();
    for (kind, all) in kinds.iter().zip(&all) {
        println!("{kind:?}: {} normals, {:.3?}", all.len(), peaks(all));
    }
}
