//! A cube with an edge crack, pulled open, sheared along and across the crack's front: Irwin's
//! modes (thesis Fig. 3.14 and 3.17 to 3.19).

use cullet_fracture::Material;
use cullet_fracture::damage::Softening;
use cullet_fracture::mpm::domain::{Fields, Grip};
use cullet_fracture::mpm::{Domain, quadrature};
use cullet_fracture::particles::Particles;
use cullet_geometry::{Vec3, inside::Inside, sample, shapes};
use std::sync::Arc;

const STONE: Material = Material {
    density: 2450.0,
    young: 32e9,
    poisson: 0.2,
    failure_stress: 3e6,
    fracture_energy: 3.0,
};
/// Grid spacing \[m\].
const H: f64 = 0.005;
/// Half the edge of the cube, in spacings.
const HALF: f64 = 8.0;

/// What a cube came to.
struct Broken {
    /// Places of the points that broke, about the crack's front, in spacings.
    points: Vec<Vec3>,
    /// Pieces of more than a tenth of the body.
    pieces: usize,
    /// When there were two pieces \[steps\].
    parted: Option<u64>,
    /// Elastic energy at the end \[J\].
    elastic: f64,
}

/// Pulls the upper half along `way` and the lower half against it; the crack lies in y = 0 for
/// x < 0, its front along z.
fn pull(way: Vec3, fields: Fields, seed: u64) -> Broken {
    let edge = 2.0 * HALF * H;
    let mesh = shapes::cuboid(Vec3::repeat(edge), shapes::Detail::default()).expect("a box");
    let inside = Inside::new(&mesh);
    let points = sample::poisson(&inside, 0.5 * H, seed).expect("points");
    let mut particles = Particles::at_rest(&points, mesh.signed_volume(), STONE.density);
    particles.volume = quadrature::volumes(&points, &inside, Vec3::repeat(H), mesh.signed_volume());
    for (strength, x) in particles.strength.iter_mut().zip(&points) {
        *strength = if x.y.abs() > 0.7 * HALF * H { 100.0 } else { 1.0 };
    }
    let law = Softening::on_grid(&STONE, H);
    let mut domain = Domain::new(particles, &STONE, law, Vec3::repeat(H));
    domain.sever(|a, b| {
        let at = a.x + (b.x - a.x) * a.y / (a.y - b.y);
        a.y > 0.0 && b.y < 0.0 && at < 0.0
    });
    domain.fields = fields;
    domain.launch(|x| way * (x.y / (HALF * H)).clamp(-1.0, 1.0));
    let grip = move |x: Vec3| (x.y.abs() > 0.8 * HALF * H).then(|| way * x.y.signum());
    domain.grip = Some(Grip(Arc::new(grip)));
    let (mut parted, mut large) = (None, 0);
    while domain.steps < 700 {
        domain.advance();
        if domain.steps.is_multiple_of(10) {
            large = pieces(&domain);
            if large > 1 && parted.is_none() {
                parted = Some(domain.steps);
            }
        }
    }
    let broken = domain.particles.reference.iter().zip(&domain.particles.damage);
    Broken {
        points: broken.filter(|(_, damage)| **damage >= 1.0).map(|(x, _)| x / H).collect(),
        pieces: large,
        parted,
        elastic: domain.elastic_energy(),
    }
}

fn pieces(domain: &Domain) -> usize {
    let pieces = domain.pieces();
    let mut sizes = std::collections::BTreeMap::new();
    for piece in pieces.iter().flatten() {
        *sizes.entry(*piece).or_insert(0) += 1;
    }
    sizes.values().filter(|&&size| size > pieces.len() / 10).count()
}

/// Layers of broken points, half a spacing each, across the part of the section that broke.
fn layers(broken: &Broken) -> f64 {
    broken.points.iter().filter(|x| x.x > 1.0).count() as f64 / (4.0 * 2.0 * HALF * (HALF - 1.0))
}

#[test]
fn an_opened_crack_runs_on_in_its_plane() {
    let broken = pull(Vec3::new(0.0, 0.01, 0.0), Fields::Split, 3);
    assert_eq!(broken.pieces, 2);
    let far = broken.points.iter().filter(|x| x.y.abs() > 2.0).count() as f64;
    assert!(far < 0.05 * broken.points.len() as f64, "{far} of {}", broken.points.len());
    let mean = broken.points.iter().map(|x| x.y).sum::<f64>() / broken.points.len() as f64;
    assert!(mean.abs() < 0.5, "{mean}");
}

/// F08: what is pressed together does not crack.
#[test]
fn a_closed_crack_stays() {
    let broken = pull(Vec3::new(0.0, -0.01, 0.0), Fields::Split, 3);
    assert_eq!(broken.points.len(), 0);
    assert_eq!(broken.pieces, 1);
}

/// Sheared along the crack, it kinks towards the side that is pulled: most points near the front
/// break between 60 and 80 degrees; the greatest hoop stress is at 70.5 (K4).
#[test]
fn a_sheared_crack_kinks() {
    for sign in [1.0, -1.0] {
        let broken = pull(Vec3::new(0.01 * sign, 0.0, 0.0), Fields::Split, 3);
        let near = broken.points.iter().filter(|x| (1.0..5.0).contains(&x.xy().norm()));
        let mut sectors = [0; 18];
        for x in near {
            let angle = (-sign * x.y).atan2(x.x).to_degrees().rem_euclid(360.0);
            sectors[(angle / 20.0) as usize] += 1;
        }
        let most = (0..18).max_by_key(|&k| sectors[k]);
        assert_eq!(most, Some(3), "{sectors:?}");
    }
}

/// Sheared across, the front breaks ahead of itself, on both sides of the plane alike.
#[test]
fn a_torn_crack_goes_on_from_its_front() {
    let broken = pull(Vec3::new(0.0, 0.0, 0.01), Fields::Split, 3);
    let mean = broken.points.iter().map(|x| x.y).sum::<f64>() / broken.points.len() as f64;
    assert!(mean.abs() < 0.5, "{mean}");
    for slab in 0..7 {
        let slab = f64::from(slab)..f64::from(slab + 1);
        let count = broken.points.iter().filter(|x| slab.contains(&x.x) && x.y.abs() < 3.0).count();
        assert!(count > 30, "{count} in {slab:?}");
    }
}

/// F17: with one field, the sides of the crack hold on to each other: more layers break and the
/// cube does not part (thesis Fig. 3.17: four layers and two).
#[test]
fn one_field_welds_what_two_let_go() {
    let way = Vec3::new(0.0, 0.01, 0.0);
    let (one, split) = (pull(way, Fields::Single, 3), pull(way, Fields::Split, 3));
    let (wide, thin) = (layers(&one), layers(&split));
    println!("layers {wide:.2} and {thin:.2}, parted after {:?} steps", split.parted);
    println!("elastic energy {:.3e} and {:.3e} J", one.elastic, split.elastic);
    assert!(thin < 0.9 * wide, "{thin} and {wide} layers");
    assert!(one.parted.is_none() && split.parted.is_some());
}
