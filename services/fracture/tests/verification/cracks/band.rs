//! F20: a zone of broken points thicker than any kernel, in which no gradient of damage tells the
//! two sides apart.

use super::specimen::{H, STONE, pieces};
use cullet_fracture::damage::Softening;
use cullet_fracture::mpm::domain::PrescribedVelocity;
use cullet_fracture::mpm::{Domain, crushed, quadrature};
use cullet_fracture::particles::Particles;
use cullet_geometry::{Vec3, inside::Inside, sample, shapes};
use cullet_model::{Material, Tolerance};
use std::sync::Arc;

/// So strong that the grid caps its strength: points break at once, all those of a layer alike.
const HARD: Material = Material { failure_stress: 18e6, ..STONE };
/// Half the edges of the block, in spacings.
const HALF: Vec3 = Vec3::new(4.0, 9.0, 4.0);
/// Speed at which its sides meet \[m/s\].
const SPEED: f64 = 0.05;

/// A block pulled along y until the layer |y| < `half` \[spacings\] is all broken.
fn torn(half: f64) -> Domain {
    let mesh = shapes::cuboid(HALF * (2.0 * H), shapes::Detail::default()).expect("a box");
    let inside = Inside::new(&mesh);
    let points = sample::poisson(&inside, 0.5 * H, 3).expect("points");
    let volume = mesh.signed_volume();
    let mut particles = Particles::at_rest(&points, volume, HARD.density);
    particles.volume = quadrature::volumes(&points, &inside, Vec3::repeat(H), volume);
    for (strength, x) in particles.strength.iter_mut().zip(&points) {
        *strength = if x.y.abs() < half * H { 0.01 } else { 100.0 };
    }
    let law = Softening::on_grid(&HARD, H);
    let mut domain = Domain::new(particles, &HARD, law, Vec3::repeat(H));
    let pulled = |y: f64| Vec3::y() * (SPEED * y / (HALF.y * H));
    domain.launch(|x| pulled(x.y));
    let held = move |x: Vec3| (x.y.abs() > (HALF.y - 1.0) * H).then(|| pulled(x.y));
    domain.prescribed = Some(PrescribedVelocity(Arc::new(held)));
    while domain.steps < 60 {
        domain.advance();
    }
    domain.prescribed = None;
    domain
}

/// Mean velocity of the whole points above and below \[m/s\].
fn speeds(domain: &Domain) -> [Vec3; 2] {
    let (particles, motions) = (&domain.particles, domain.motions());
    [1.0, -1.0].map(|side| {
        let (mut sum, mut count) = (Vec3::zeros(), 0.0);
        for (p, motion) in motions.iter().enumerate() {
            if particles.damage[p] < 1.0 && side * particles.reference[p].y > 0.0 {
                sum += motion.velocity;
                count += 1.0;
            }
        }
        sum / count
    })
}

/// Mean stress along y \[Pa\].
fn squeeze(domain: &Domain) -> f64 {
    domain.stresses().iter().map(|s| s[1]).sum::<f64>() / domain.particles.len() as f64
}

/// Four cells of rubble: the sides are two, meet without a shove aside, bear the blow and fly apart
/// again as fast from then on. On the way the energy counts what rubble bears twice, by a sixth.
#[test]
fn the_sides_of_a_thick_band_part_meet_and_part_again() {
    let mut domain = torn(2.0);
    let particles = &domain.particles;
    let points = (0..particles.len()).filter(|&p| particles.reference[p].y.abs() < 2.0 * H);
    let directed = |&p: &usize| particles.damage[p] >= 1.0 && particles.normal[p].y.abs() > 0.8;
    let (all, broken) = (points.clone().count(), points.filter(directed).count());
    assert!(all > 1500 && broken as f64 > 0.98 * all as f64, "{broken} of {all}");
    assert_eq!(pieces(&domain), 2);

    domain.launch(|x| Vec3::y() * (-SPEED * x.y.signum()));
    let energy = |domain: &Domain| domain.kinetic_energy() + domain.elastic_energy();
    let start = energy(&domain);
    let (mut most, mut aside, mut hardest, mut soon) = (0.0_f64, 0.0_f64, 0.0_f64, 0.0);
    for step in 1..=300 {
        domain.advance();
        most = most.max(energy(&domain) / start);
        aside = aside.max(speeds(&domain).iter().map(|v| v.xz().norm()).fold(0.0, f64::max));
        hardest = hardest.min(squeeze(&domain));
        if step == 150 {
            soon = speeds(&domain)[0].y;
        }
    }
    let (end, [up, down]) = (energy(&domain) / start, speeds(&domain).map(|v| v.y));
    println!("energy {most:.3} at most, {end:.3} at the end; {hardest:.2e} Pa; aside {aside:.1e}");
    println!("speeds {soon:.4} m/s, then {up:.4} and {down:.4} m/s");
    assert!(most < 1.1 && end < 1.02, "{most} and {end}");
    assert!(aside < 0.05 * SPEED, "{aside} m/s");
    // Half of what a wave of this speed bears, ρcv.
    assert!(hardest < -0.3 * HARD.density * HARD.pressure_speed() * SPEED, "{hardest} Pa");
    assert!(up > 0.7 * SPEED && (up + down).abs() < 0.02 * SPEED, "{up} and {down}");
    assert!((up / soon - 1.0).abs() < 0.05, "{soon} and {up}");
}

/// A band of three cells is the crack's, to be shared by its sides; one of ten is a crushed zone.
#[test]
fn rubble_beyond_a_cracks_band_is_divided() {
    let (spacing, tolerance) = (Vec3::repeat(H), Tolerance::default());
    let push = Vec3::z();
    let rules =
        crushed::CrushRules { spacing, material: HARD, seed: 1, tolerance, most: 400, push };
    for (half, wide) in [(1.5, false), (5.0, true)] {
        let mut domain = torn(half);
        // Torn so fast that grains are as small as the grid can tell.
        domain.particles.onset_rate.fill(1e7);
        let found = crushed::pieces(&domain.particles, domain.pieces(), &rules);
        println!("{half}: {} drawn, {:.3} of the body", found.rubble.balls.len(), found.crushed);
        assert_eq!(found.rubble.balls.len() > 1, wide);
        assert_eq!(found.crushed > 0.1, wide);
    }
}
