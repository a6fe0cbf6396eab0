//! What strikers do: F11 to F13, F73.

use crate::kit::{
    H, PLASTER, STRONG, blow, body, cuboid, energy, keeps_the_books, problem, rows, solved, told,
};
use cullet_fracture::damage::{DamageState, Softening};
use cullet_fracture::mpm::crushed::{CrushRules, pieces};
use cullet_fracture::mpm::load::ImpactLoad;
use cullet_geometry::Vec3;
use cullet_model::hertz_contact::HertzContact;
use cullet_model::{BrittleProblem, Impact, Tolerance};
use std::f64::consts::PI;

/// A cube of 0.1 m that is hit in the middle of a face.
fn cube(impact: Impact) -> BrittleProblem {
    problem(cuboid(Vec3::repeat(0.1)), PLASTER, impact)
}

fn tap() -> Impact {
    blow(Vec3::new(-0.05, 0.0, 0.0), Vec3::x(), 1e-4)
}

/// F11: a contact of a tenth of a cell is spread over a disc of two cells, and told; what lies
/// under it does not break while it is pressed, and breaks when it is pulled.
#[test]
fn f11_a_contact_is_no_point() {
    let domain = body(&rows([8, 8, 8]), &STRONG);
    let impact = Impact { point: Vec3::new(-4.0 * H, 0.0, 0.0), radius: 0.1 * H, ..tap() };
    let load = ImpactLoad::new(&impact, &domain, impact.duration, 1.0);
    let place = |id: u32| domain.particles.reference[domain.slot(id)];
    let shares = load.patch.shares();
    let reach = shares.iter().map(|(id, _)| place(*id).yz().norm()).fold(0.0, f64::max);
    let most = shares.iter().map(|(_, share)| *share).fold(0.0, f64::max);
    assert!(load.radius == 2.0 * H && reach > 1.5 * H && most < 0.05, "{reach} m, {most}");
    assert!((shares.iter().map(|(_, share)| share).sum::<f64>() - 1.0).abs() < 1e-12);
    assert!(told("F11", &cube(tap())));
    assert!(!told("F11", &cube(Impact { radius: 0.04, ..tap() })));

    let law = Softening::new(&PLASTER, 0.001);
    let under = DamageState { damage: 0.0, strength: 1.0, shielded: true, lone: 1.0 };
    let one = law.strength / PLASTER.young;
    let squeezed = [3.8, -4.6, 0.2, 0.0, 0.0, 0.0].map(|e| e * one);
    let pulled = [3.0, -0.6, -0.6, 0.0, 0.0, 0.0].map(|e| e * one);
    assert!(law.respond(&squeezed, DamageState { shielded: false, ..under }).damage > 0.0);
    assert_eq!(law.respond(&squeezed, under).damage, 0.0);
    assert!(law.respond(&pulled, under).damage > 0.0);
}

/// F12: however great the impulse asked for, a body gets no more than the striker can pay: 2 m* v,
/// as from an elastic blow, and the work that this is. A push too long for its solve is shortened
/// and told, and the body has what was given, once.
#[test]
fn f12_a_push_ends_when_the_striker_has_nothing_left() {
    let mut domain = body(&rows([8, 8, 8]), &STRONG);
    let mass = STRONG.density * 512.0 * 1e-6;
    let (striker, speed) = (0.3, 5.0);
    let reduced = 1.0 / (1.0 / striker + 1.0 / mass);
    let elastic = 2.0 * reduced * speed;
    let impact = Impact {
        point: Vec3::new(-4.0 * H, 0.0, 0.0),
        impulse: 1.5 * elastic,
        energy: 0.5 * reduced * speed * speed,
        closing_speed: speed,
        duration: 2e-3,
        ..tap()
    };
    let mut load = ImpactLoad::new(&impact, &domain, impact.duration, 1.0 / mass);
    while !load.is_over() {
        load.push(&mut domain);
        domain.advance();
        load.book(&domain);
    }
    let given = load.delivered / elastic;
    assert!((0.85..=1.02).contains(&given), "{given} of an elastic blow");
    let lost = load.delivered * speed - 0.5 * load.delivered * load.delivered / striker;
    assert!(load.work <= lost * 1.01, "{} of {lost} J", load.work);
    let carried = domain.momentum().x;
    assert!((carried / load.delivered - 1.0).abs() < 1e-9, "{carried} of {}", load.delivered);

    let long = cube(Impact { duration: 0.02, ..tap() });
    let fracture = solved(&long);
    let share =
        fracture.report.detail("delivered_impulse").unwrap_or_default() / long.impacts[0].impulse;
    assert!(fracture.report.warnings.iter().any(|line| line.contains("shortened")), "{share}");
    assert!(share < 0.5 && share > 0.0, "{share}");
    keeps_the_books("shortened", &long, &fracture);
    assert!(!told("F12", &cube(tap())));
}

/// F13: a contact that cannot bear its pressure yields, with less force and little given back, and
/// is told; where cracks run closer than the grid can tell the body is divided into grains.
#[test]
fn f13_a_weak_contact_crushes_and_crushed_zones_are_divided() {
    let hard = Impact { energy: 1.0, impulse: 0.1, ..tap() };
    let peak = |impact: &Impact| {
        let contact = HertzContact::new(impact);
        let wide = contact.radius(contact.depth(impact.energy));
        (contact.crushes(impact.energy), contact.peak(impact.energy), wide)
    };
    let (crushes, force, wide) = peak(&hard);
    let pressure = 1.5 * force / (PI * wide * wide);
    assert!(!crushes);
    let weak = Impact { crushing_pressure: 0.1 * pressure, ..hard };
    let (crushes, less, wider) = peak(&weak);
    let mean = less / (PI * wider * wider);
    assert!(crushes && less < 0.4 * force && wider > wide, "{less} of {force} N");
    assert!(mean < 0.1 * pressure && mean > 0.08 * pressure, "{mean} of {pressure} Pa");
    let mut contact = HertzContact::new(&weak);
    let deep = contact.depth(weak.energy);
    let way_in = contact.force(0.8 * deep);
    contact.force(deep);
    let back = contact.force(0.8 * deep);
    assert!(back < 0.5 * way_in, "{back} and {way_in} N");
    assert!(told("F13", &cube(Impact { crushing_pressure: 1e3, ..tap() })));
    assert!(!told("F13", &cube(tap())));

    let domain = body(&rows([20, 5, 5]), &PLASTER);
    let mut particles = domain.particles.clone();
    // Torn so fast that grains are as small as the grid can tell.
    particles.onset_rate.fill(1e7);
    let rules = CrushRules {
        spacing: Vec3::repeat(H),
        material: PLASTER,
        seed: 1,
        tolerance: Tolerance::default(),
        most: 400,
        push: Vec3::x(),
    };
    let divided = |whole: f64| {
        let mut left = vec![None; particles.len()];
        for (x, &id) in particles.reference.iter().zip(&particles.id) {
            left[id as usize] = (x.x > whole * H).then_some(0);
        }
        pieces(&particles, left, &rules)
    };
    let (none, half) = (divided(-10.0), divided(0.0));
    assert_eq!((none.rubble.balls.len(), none.crushed), (0, 0.0));
    assert!(half.rubble.balls.len() > 4 && (half.crushed - 0.4).abs() < 0.15, "{}", half.crushed);
}

/// F73: a striker so light and stiff that its contact is over within a step gives no more than it
/// has: neither impulse nor energy.
#[test]
fn f73_a_stiff_light_striker_gives_no_more_than_it_has() {
    for share in [0.02, 0.3, 1.0, 4.0, 30.0] {
        let mut domain = body(&rows([8, 8, 8]), &STRONG);
        let mass = STRONG.density * 512.0 * 1e-6;
        let (striker, speed) = (1e-3 * mass, 20.0);
        let reduced = 1.0 / (1.0 / striker + 1.0 / mass);
        let impact = Impact {
            impulse: 2.0 * reduced * speed,
            energy: 0.5 * reduced * speed * speed,
            closing_speed: speed,
            duration: share * domain.step,
            radius: 1e-3,
            ..blow(Vec3::new(-0.04, 0.0, 0.0), Vec3::x(), 1.0)
        };
        let mut load = ImpactLoad::new(&impact, &domain, impact.duration, 1.0 / mass);
        let mut most: f64 = 0.0;
        while !load.is_over() {
            load.push(&mut domain);
            domain.advance();
            most = most.max(energy(&domain));
        }
        println!("{share} steps: {:.3} of the impulse", load.delivered / impact.impulse);
        assert!(load.delivered <= impact.impulse * (1.0 + 1e-12), "{share}");
        assert!(most <= 1.02 * impact.energy, "{share} steps: {most} of {} J", impact.energy);
    }
}
