//! The point law: what it spends, keeps and bears.

use super::{BodyWeakPlane, DamageState, Response, Softening};
use crate::mpm::symmetric::Sym3;
use cullet_geometry::math::unit;
use cullet_model::Material;

/// So stiff that no strain is large.
const STONE: Material = Material {
    density: 2450.0,
    young: 32e15,
    poisson: 0.2,
    failure_stress: 3e6,
    fracture_energy: 3e-6,
};

/// A point as good as new, or of that damage.
fn state(damage: f64) -> DamageState {
    DamageState { damage, strength: 1.0, shielded: false, lone: 1.0 }
}

/// Hooke's strain.
fn strain(s: Sym3) -> Sym3 {
    let (young, poisson) = (STONE.young, STONE.poisson);
    let mean = poisson * (s[0] + s[1] + s[2]);
    let part = |k: usize| ((1.0 + poisson) * s[k] - if k < 3 { mean } else { 0.0 }) / young;
    [0, 1, 2, 3, 4, 5].map(part)
}

/// A bar with free sides, drawn until its solid bears `stress` between the cracks.
fn draw(law: &Softening, stress: f64, damage: f64) -> Response {
    let left = 1.0 - law.damage(stress / law.strength).max(damage);
    let side = -STONE.poisson * left * stress / STONE.young;
    law.respond(&[stress / STONE.young, side, side, 0.0, 0.0, 0.0], state(damage))
}

/// A point whose sides are held, or pulled as well, spends G_f/l as a bar does.
#[test]
fn a_point_spends_as_much_however_many_directions_are_pulled() {
    let length = 0.002;
    let law = Softening::new(&STONE, length);
    assert!(law.brittleness < 0.3, "thrice that share is below the cap: {}", law.brittleness);
    for sides in [[0.0, 0.0], [1.0, 0.0], [1.0, 1.0], [0.5, -0.2]] {
        let (mut damage, mut spent) = (0.0, 0.0);
        for step in 1..=4000 {
            let e = 3.0 * law.breaking_strain() * f64::from(step) / 4000.0;
            let strain = [e, sides[0] * e, sides[1] * e, 0.0, 0.0, 0.0];
            let response = law.respond(&strain, state(damage));
            damage = response.damage;
            spent += response.dissipated;
        }
        assert!(damage >= 1.0, "{sides:?}: {damage}");
        let share = spent * length / STONE.fracture_energy;
        assert!((share - 1.0).abs() < 0.02, "{sides:?}: {share} of G_f/l");
    }
}

/// F-U: the area under σ–ε is G_f/l.
#[test]
fn the_point_law_spends_the_fracture_energy() {
    let length = 0.008;
    let law = Softening::new(&STONE, length);
    let last = law.strength * (1.0 + 1.0 / law.brittleness);
    assert_eq!(law.strength, 3e6);
    assert!((last / law.strength - law.threshold(1.0)).abs() < 1e-12);
    let (mut damage, mut area, mut dissipated) = (0.0, 0.0, 0.0);
    let (mut strain, mut before) = (0.0, 0.0);
    // σ(ε) is piecewise linear, so a trapezium over steps that include both kinks is exact.
    let mut ramp: Vec<f64> = (0..=400).map(|i| last * f64::from(i) / 400.0).collect();
    ramp.extend([law.strength, last * (1.0 + 1e-6)]);
    ramp.sort_by(f64::total_cmp);
    for effective in ramp {
        let response = draw(&law, effective, damage);
        let stress = response.stress[0];
        if effective <= law.strength {
            assert!(response.damage < 1e-8);
        }
        area += 0.5 * (stress + before) * (effective / STONE.young - strain);
        dissipated += response.dissipated;
        (strain, before, damage) = (effective / STONE.young, stress, response.damage);
    }
    let wanted = STONE.fracture_energy / length;
    assert!((damage - 1.0).abs() < 1e-12, "damage {damage}");
    assert!((area / wanted - 1.0).abs() < 1e-5, "area {area} of {wanted}");
    assert!((dissipated / wanted - 1.0).abs() < 1e-5, "dissipated {dissipated} of {wanted}");
}

/// With held sides the pull is greater and cracks relieve it: the same energy.
#[test]
fn a_point_with_held_sides_spends_the_same() {
    let law = Softening::new(&STONE, 0.008);
    let last = law.strength * (1.0 + 1.0 / law.brittleness) / STONE.young;
    let (mut damage, mut dissipated) = (0.0, 0.0);
    for i in 1..=2000 {
        let stretch = 1.25 * last * f64::from(i) / 2000.0;
        // A slight squeeze keeps the sides from being pulled as well.
        let side = -0.3 * stretch;
        let strain = [stretch, side, side, 0.0, 0.0, 0.0];
        let response = law.respond(&strain, state(damage));
        assert!(response.damage >= damage);
        dissipated += response.dissipated;
        damage = response.damage;
    }
    let wanted = STONE.fracture_energy / 0.008;
    assert_eq!(damage, 1.0);
    assert!((dissipated / wanted - 1.0).abs() < 2e-3, "{dissipated} of {wanted}");
}

/// A pull across weak planes breaks them first; along them the strength is the material's.
#[test]
fn weak_planes_break_first() {
    let plane = BodyWeakPlane { normal: [0.6, 0.8, 0.0], ratio: 0.5 };
    let law = Softening { weak_plane: Some(plane), ..Softening::new(&STONE, 0.008) };
    let pull = |n: [f64; 3], size: f64| {
        let s = size * law.strength;
        let stress = [n[0] * n[0], n[1] * n[1], n[2] * n[2], n[0] * n[1], n[1] * n[2], 0.0];
        law.respond(&strain(stress.map(|x| s * x)), state(0.0))
    };
    assert_eq!(pull(plane.normal, 0.49).damage, 0.0);
    let across = pull(plane.normal, 0.51);
    assert!(across.damage > 0.0);
    assert_eq!(across.normal, plane.normal);
    assert_eq!(pull([0.8, -0.6, 0.0], 0.99).damage, 0.0);
    assert!(pull([0.8, -0.6, 0.0], 1.01).damage > 0.0);
    // At 60 degrees the weak planes feel a quarter of the pull, and their strength is half.
    assert_eq!(pull([0.0, 0.0, 1.0], 0.99).damage, 0.0);
}

/// Pure shear: only the pulled principal direction weakens. Once it is open, what presses the
/// other is Young's modulus times its strain, not shear alone.
#[test]
fn weakening_is_one_sided_in_shear() {
    let law = Softening::new(&STONE, 0.008);
    let s = 10.0 * law.strength;
    let response = law.respond(&strain([0.0, 0.0, 0.0, s, 0.0, 0.0]), state(0.0));
    assert_eq!(response.damage, 1.0);
    // Along n = (1,−1,0)/√2 the strain is −s/2μ, across the plane it stays none: with the
    // other free, −E/(1−ν²) of it, of which ν goes out of the plane.
    let (along, out) = (-s / (1.0 - STONE.poisson), -STONE.poisson * s / (1.0 - STONE.poisson));
    let wanted = [0.5 * along, 0.5 * along, out, -0.5 * along, 0.0, 0.0];
    for (a, b) in response.stress.iter().zip(&wanted) {
        assert!((a - b).abs() < 1e-6 * s, "{:?}, not {wanted:?}", response.stress);
    }
}

/// The stress is the slope of one energy: around closed ways of strain, small or not, through
/// opening, closing, tearing and turning, no work is left.
#[test]
fn no_way_around_makes_or_takes_energy() {
    for (index, poisson) in (0..60).zip([0.0, 0.2, 0.3, 0.45, -0.3].into_iter().cycle()) {
        let soft = Material { young: 3e9, poisson, ..STONE };
        let law = Softening::new(&soft, 0.008);
        let random = |stream, k| 2.0 * unit(stream, k, index) - 1.0;
        let (damage, size) = ([1.0, 0.6, 1.0][index as usize % 3], [1e-3, 1e-3, 0.1]);
        let size = size[index as usize % 3];
        let held = DamageState { strength: 1e12, ..state(damage) };
        let way = |a: f64| -> Sym3 {
            let (s, c) = libm::sincos(std::f64::consts::TAU * a);
            [0, 1, 2, 3, 4, 5].map(|k| size * (random(1, k) * s + random(2, k) * (c - 0.5)))
        };
        let steps = 4000;
        let at = |i: i32| way(f64::from(i) / f64::from(steps));
        let (mut sum, mut traffic) = (0.0, 0.0);
        for i in 0..steps {
            let (a, b) = (at(i), at(i + 1));
            let middle = [0, 1, 2, 3, 4, 5].map(|k| 0.5 * (a[k] + b[k]));
            let stress = law.respond(&middle, held).stress;
            let part = |k: usize| stress[k] * (b[k] - a[k]) * if k < 3 { 1.0 } else { 2.0 };
            let work: f64 = (0..6).map(part).sum();
            (sum, traffic) = (sum + work, traffic + work.abs());
        }
        let lost = sum.abs() / traffic;
        assert!(lost < 2e-3, "case {index}, {poisson}, {damage}: {lost} of the work");
    }
}
