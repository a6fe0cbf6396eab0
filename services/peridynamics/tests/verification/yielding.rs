//! C6: a point that is pulled in one direction yields, hardens and unloads as a metal does.

use crate::block;
use cullet_geometry::Vec3;
use cullet_model::{DuctileFailure, Hardening};
use cullet_peridynamics::{PeridynamicDomain, PeridynamicLaw};

const YOUNG: f64 = 200e9;
const POISSON: f64 = 0.3;

fn steel(yield_stress: f64, hardening: f64) -> PeridynamicLaw {
    let hardening = Some(Hardening { yield_stress, hardening, exponent: 1.0 });
    PeridynamicLaw { hardening, ..PeridynamicLaw::elastic(7800.0, YOUNG, POISSON) }
}

/// A block whose points are moved as a strain along one axis and one across it say.
struct Sample {
    body: PeridynamicDomain,
    start: Vec<Vec3>,
    middle: usize,
    /// Strain across that the last pull found.
    across: f64,
}

impl Sample {
    fn new(law: PeridynamicLaw) -> Self {
        let body = block([9, 9, 9], 1e-3, 0.1, 3.015, law);
        let start = body.places.clone();
        let middle = (0..start.len()).min_by(|&a, &b| start[a].norm().total_cmp(&start[b].norm()));
        Self { body, start, middle: middle.expect("a point"), across: 0.0 }
    }

    fn place(body: &mut PeridynamicDomain, start: &[Vec3], along: f64, across: f64) {
        for (x, s) in body.places.iter_mut().zip(start) {
            *x = s + Vec3::new(across * s.x, across * s.y, along * s.z);
        }
        body.strain();
    }

    /// Strains it along one axis with nothing across; the stress along it \[Pa\].
    fn pull(&mut self, along: f64) -> f64 {
        let (mut low, mut high) = (-along.abs() - 1e-3, along.abs() + 1e-3);
        for _ in 0..40 {
            let middle = 0.5 * (low + high);
            let mut tried = self.body.clone();
            Self::place(&mut tried, &self.start, along, middle);
            let stress = tried.stress(self.middle);
            let pulls = stress[(0, 0)] + stress[(1, 1)] > 0.0;
            *(if pulls { &mut high } else { &mut low }) = middle;
        }
        self.across = 0.5 * (low + high);
        Self::place(&mut self.body, &self.start, along, self.across);
        self.body.stress(self.middle)[(2, 2)]
    }
}

/// Yield stress within 1 %, slope of hardening within 3 %, unloading within 1 % of E, what is left
/// when the load has gone within 3 %.
#[test]
fn c6_a_point_yields_hardens_and_unloads() {
    let (yields, hardens) = (200e6, 20e9);
    let mut sample = Sample::new(steel(yields, hardens));
    let elastic = yields / YOUNG;
    let first = sample.pull(0.5 * elastic);
    assert!((first / (0.5 * yields) - 1.0).abs() < 0.01, "elastic: {first}");
    let mut stresses = Vec::new();
    for step in 1..=20 {
        stresses.push(sample.pull(elastic * (1.0 + 0.2 * f64::from(step))));
    }
    // σ = σ_y + EH/(E + H) (ε − σ_y/E).
    let slope = YOUNG * hardens / (YOUNG + hardens);
    let found = (stresses[19] - stresses[9]) / (2.0 * elastic);
    println!(
        "C6: slope {:.4}, last {:.4}",
        found / slope,
        stresses[19] / (yields + slope * 4.0 * elastic)
    );
    assert!((found / slope - 1.0).abs() < 0.03, "hardening by {found}");
    assert!((stresses[19] / (yields + slope * 4.0 * elastic) - 1.0).abs() < 0.01, "{stresses:?}");
    let back = sample.pull(4.5 * elastic);
    let modulus = (stresses[19] - back) / (0.5 * elastic);
    println!("C6: unloads with {:.4} E", modulus / YOUNG);
    assert!((modulus / YOUNG - 1.0).abs() < 0.01, "unloads with {modulus}");
    let left = 4.5 * elastic - back / YOUNG;
    let wanted = 4.0 * elastic - slope * 4.0 * elastic / YOUNG;
    assert!((left / wanted - 1.0).abs() < 0.03, "{left} is left of {wanted}");
    let plastic = sample.body.states[sample.middle].plastic;
    assert!((plastic / wanted - 1.0).abs() < 0.03, "{plastic}");
}

/// Ten times the yield stress all round: nothing flows, at any point.
#[test]
fn c6_nothing_flows_under_pressure() {
    let law = steel(200e6, 0.0);
    let mut sample = Sample::new(law);
    let strain = -10.0 * 200e6 / (3.0 * law.bulk);
    Sample::place(&mut sample.body, &sample.start, strain, strain);
    let pressure = -sample.body.stress(sample.middle).trace() / 3.0;
    assert!((pressure / 2e9 - 1.0).abs() < 0.01, "{pressure}");
    assert!(sample.body.states.iter().all(|state| state.plastic == 0.0));
}

/// Extensions are linear: what flows far loses volume.
#[test]
fn what_flows_far_loses_volume() {
    let yields = 200e6;
    let mut sample = Sample::new(steel(yields, 0.0));
    for (along, [low, high]) in [(0.01, [0.999, 1.001]), (0.1, [0.98, 0.995])] {
        sample.pull(along);
        let widths = |axis: usize| {
            let points = sample.body.places.iter().zip(&sample.start);
            points.map(|(x, s)| x[axis] * s[axis]).sum::<f64>()
                / sample.start.iter().map(|s| s[axis] * s[axis]).sum::<f64>()
        };
        let volume = widths(0) * widths(1) * widths(2);
        println!("C6: strained by {along}, {volume:.4} of the volume is left");
        assert!((low..high).contains(&volume), "{along}: {volume}");
    }
}

/// γ: what is pulled flows up to it, and is elastic beyond; drawn back it flows again.
#[test]
fn a_point_flows_up_to_its_limit() {
    for limit in [5e-3, 1e-2] {
        let law = PeridynamicLaw { max_plastic_stretch: Some(limit), ..steel(200e6, 0.0) };
        let mut sample = Sample::new(law);
        let steps = |sample: &mut Sample, from: f64, to: f64| {
            let at = |k: i32| from + (to - from) * f64::from(k) / 20.0;
            let stresses: Vec<f64> = (1..=20).map(|k| sample.pull(at(k))).collect();
            (stresses[19] - stresses[15]) / (at(20) - at(16)) / YOUNG
        };
        let slope = steps(&mut sample, 0.0, 2.5 * limit);
        let plastic = sample.body.states[sample.middle].plastic;
        println!("γ {limit}: flowed {plastic:.5}, then {slope:.4} E");
        assert!((plastic / limit - 1.0).abs() < 0.03, "{limit}: {plastic}");
        // Linear extensions of longer bonds are stiffer by one and a half of their strain.
        assert!((slope - 1.0).abs() < 0.01 + 1.5 * 2.5 * limit, "{limit}: {slope} E");
        // As far back again, and as far to the other side.
        steps(&mut sample, 2.5 * limit, -2.5 * limit);
        let all = sample.body.states[sample.middle].plastic;
        println!("γ {limit}: flowed {all:.5} when pressed");
        assert!((all / (3.0 * limit) - 1.0).abs() < 0.05, "{limit}: {all}");
    }
}

/// A point that is pulled fails at Johnson and Cook's strain for its triaxiality of 1/3: its bonds
/// along the load break, not those across, which are pressed. One that is pressed by as much has
/// less damage by the ratio of both strains.
#[test]
fn what_flows_too_far_breaks_in_tension() {
    let ductile = DuctileFailure { d: [2e-3, 1e-2, -1.5, 0.0, 0.0] };
    let law = PeridynamicLaw { ductile: Some(ductile), ..steel(200e6, 1e9) };
    let mut sample = Sample::new(law);
    let due = ductile.strain(1.0 / 3.0);
    let mut along = 0.0;
    let state = |sample: &Sample| sample.body.states[sample.middle];
    while state(&sample).ductile < 1.0 && along < 0.05 {
        along += 1e-4;
        sample.pull(along);
        assert_eq!(state(&sample).damage, 0.0);
    }
    let fails = state(&sample).plastic;
    println!("Ductile: fails at {fails:.5}, due {due:.5}");
    assert!((fails / due - 1.0).abs() < 0.03, "fails at {fails}, due {due}");
    Sample::place(&mut sample.body, &sample.start, along, sample.across);
    let body = &sample.body;
    let of = |broken: bool| {
        let bonds = body.bonds.of(sample.middle).filter(|&b| (body.left(b) == 0.0) == broken);
        let slopes = bonds.map(|b| {
            let xi = sample.start[b.end] - sample.start[sample.middle];
            xi.z.abs() / xi.norm()
        });
        slopes.collect::<Vec<f64>>()
    };
    let (broken, whole) = (of(true), of(false));
    let least = broken.iter().copied().fold(1.0, f64::min);
    let most = whole.iter().copied().fold(0.0, f64::max);
    println!(
        "Ductile: {} broken from {least:.2}, {} whole up to {most:.2}",
        broken.len(),
        whole.len()
    );
    assert!(broken.len() > 20 && whole.len() > 20, "{} {}", broken.len(), whole.len());
    assert!(least > 0.4 && most < 0.6, "{least}, {most}");
    let damage = |sign: f64| {
        let mut sample = Sample::new(law);
        for k in 1..=10 {
            sample.pull(sign * 4e-4 * f64::from(k));
        }
        let state = sample.body.states[sample.middle];
        state.ductile / state.plastic
    };
    let ratio = damage(1.0) / damage(-1.0) * ductile.strain(1.0 / 3.0) / ductile.strain(-1.0 / 3.0);
    println!("Ductile: damage pulled over pressed {ratio:.4} of what is due");
    assert!((ratio - 1.0).abs() < 0.03, "{ratio}");
}
