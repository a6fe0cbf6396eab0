//! F-B: a pulled bar breaks in a band that dissipates G_f per area, whatever the grid.

use cullet_fracture::Material;
use cullet_fracture::damage::{BAND_WIDTH, Softening};
use cullet_fracture::mpm::Domain;
use cullet_fracture::particles::Particles;
use cullet_geometry::{Vec3, inside::Inside, sample, shapes};

const STONE: Material = Material {
    density: 2450.0,
    young: 32e9,
    poisson: 0.2,
    failure_stress: 3e6,
    fracture_energy: 3.0,
};
/// Half the length of the bar \[m\].
const HALF: f64 = 0.05;
/// Speed of each end \[m/s\].
const SPEED: f64 = 0.01;
/// Long enough to reach the strength, break, and come to rest \[s\].
const DURATION: f64 = 5e-4;

/// The ends move apart.
fn pull(at: Vec3) -> Option<Vec3> {
    (at.x.abs() > 0.9 * HALF).then(|| Vec3::new(SPEED * at.x.signum(), 0.0, 0.0))
}

/// A bar four spacings wide that is already moving as it will.
fn bar(spacing: f64, seed: u64) -> Domain {
    let size = Vec3::new(2.0 * HALF, 4.0 * spacing, 4.0 * spacing);
    let mesh = shapes::cuboid(size, shapes::Detail::default()).expect("a box");
    let points = sample::poisson(&Inside::new(&mesh), 0.5 * spacing, seed).expect("points");
    let mut particles = Particles::at_rest(&points, mesh.signed_volume(), STONE.density);
    for (p, x) in points.iter().enumerate() {
        // Two percent weaker in the middle; the grips hold.
        particles.strength[p] = match x.x.abs() {
            far if far > 0.8 * HALF => 10.0,
            near if near < 0.25 * spacing => 0.98,
            _ => 1.0,
        };
        particles.velocity[p].x = SPEED * (x.x / (0.9 * HALF)).clamp(-1.0, 1.0);
    }
    let law = Softening::new(&STONE, BAND_WIDTH * spacing);
    assert_eq!(law.strength_ratio, 1.0, "the grid resolves the material");
    let mut domain = Domain::new(particles, &STONE, law, spacing);
    domain.grip = Some(pull);
    domain
}

/// Dissipated energy per area over G_f.
fn spent(spacing: f64, seed: u64) -> f64 {
    let mut domain = bar(spacing, seed);
    let mut energy = 0.0;
    while domain.time < DURATION {
        energy += domain.advance().dissipated;
    }
    energy / (16.0 * spacing * spacing) / STONE.fracture_energy
}

/// A single bar dissipates 0.75 to 1.6 G_f: the points lie at random, and a second crack may start
/// before the first has relieved the bar. The calibration is of the mean.
#[test]
fn a_bar_spends_the_fracture_energy_on_two_grids() {
    let mean = |spacing: f64, seeds: u64| {
        (0..seeds).map(|seed| spent(spacing, seed)).sum::<f64>() / seeds as f64
    };
    let coarse = mean(0.008, 8);
    assert!((coarse - 1.0).abs() < 0.05, "h = 8 mm: {coarse} G_f");
    let fine = mean(0.004, 12);
    assert!((fine - 1.0).abs() < 0.05, "h = 4 mm: {fine} G_f");
}
