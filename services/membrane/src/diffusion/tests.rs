use super::{DiffusionBonds, DiffusionStep, ObjectContacts, share_at};
use crate::bonds::MembraneBonds;
use crate::outline::SheetOutline;
use crate::points::{SheetPoints, relaxed};
use crate::tests::{setup, with};
use cullet_model::{
    ContinuumBody, MembraneSheet, SheetDiffusion, SheetRegion, SheetSource, SheetSourceKind,
};

struct Plate {
    sheet: MembraneSheet,
    points: SheetPoints,
    bonds: MembraneBonds,
    spread: DiffusionBonds,
    damage: Vec<f64>,
}

pub(crate) fn paper() -> SheetDiffusion {
    SheetDiffusion {
        capacity: 2.0,
        conductivity: [3.0, 3.0],
        expansion: [0.0; 2],
        start: 0.0,
        saturation: f64::INFINITY,
        stiffness: vec![],
        toughness: vec![],
        strength: vec![],
        exposure: 0.0,
        weight: 0.0,
        loss: 0.0,
        ambient: 0.0,
        sources: vec![],
    }
}

fn plate(what: SheetDiffusion, notches: Vec<Vec<[f64; 2]>>, spacing: f64) -> Plate {
    between([0.0, 1.0], what, notches, spacing)
}

/// A plate of height 1 between two x.
fn between(
    [low, high]: [f64; 2],
    what: SheetDiffusion,
    notches: Vec<Vec<[f64; 2]>>,
    spacing: f64,
) -> Plate {
    let setup = with(setup(), |sheet| {
        sheet.outline = vec![[low, 0.0], [high, 0.0], [high, 1.0], [low, 1.0]];
        sheet.spacing = spacing;
        sheet.notches = notches;
        sheet.diffusion = Some(what).into();
    });
    let ContinuumBody::Membrane(sheet) = setup.body else { unreachable!() };
    let outline = SheetOutline::new(&sheet.outline).unwrap();
    let points = relaxed(&outline, sheet.spacing, 5).unwrap();
    let mut bonds = MembraneBonds::new(&points, &outline, sheet.spacing, 3.015).unwrap();
    let what = &sheet.diffusion.all[0];
    let spread = DiffusionBonds::new(&points, &bonds, &sheet, what).unwrap();
    bonds.cut_along(&sheet.notches, &points.places);
    let damage = bonds.cut.iter().map(|&cut| f64::from(u8::from(cut))).collect();
    Plate { sheet, points, bonds, spread, damage }
}

impl Plate {
    fn advance(&self, theta: &mut [f64], cycles: u32) -> f64 {
        let (mut exposure, mut next) = (vec![0.0; theta.len()], Vec::new());
        let contacts = ObjectContacts::default();
        let step = |k: u32| DiffusionStep {
            what: &self.sheet.diffusion.all[0],
            areas: &self.points.areas,
            contacts: &contacts,
            damage: &self.damage,
            time: f64::from(k) * self.spread.step,
            dt: self.spread.step,
        };
        (0..cycles).map(|k| self.spread.advance(step(k), theta, &mut exposure, &mut next)).sum()
    }
}

/// T4: the decay of a cosine along x and y gives K, the same or four times as much across.
#[test]
fn cosines_decay_by_the_diffusivity() {
    let pi = std::f64::consts::PI;
    for (conductivity, bound) in [([3.0, 3.0], 0.01), ([1.5, 6.0], 0.02)] {
        let plate = plate(SheetDiffusion { conductivity, ..paper() }, vec![], 0.025);
        for axis in 0..2 {
            let mode = |p: &[f64; 2]| (pi * p[axis]).cos();
            let mut theta: Vec<f64> = plate.points.places.iter().map(mode).collect();
            let size = |theta: &[f64]| -> f64 {
                let all = theta.iter().zip(&plate.points.places).zip(&plate.points.areas);
                all.map(|((t, p), a)| t * mode(p) * a).sum()
            };
            let before = size(&theta);
            plate.advance(&mut theta, 400);
            let time = 400.0 * plate.spread.step;
            let found = (before / size(&theta)).ln() / (pi * pi * time) * 2.0;
            assert!((found / conductivity[axis] - 1.0).abs() < bound, "{axis}: {found}");
        }
    }
}

/// T4: what a point gives spreads with the right variance, never below zero, and is kept.
#[test]
fn a_point_source_is_kept_and_positive() {
    let plate = plate(paper(), vec![], 0.025);
    let off = |i: &usize| {
        let [x, y] = plate.points.places[*i];
        (x - 0.5).hypot(y - 0.5)
    };
    let all = 0..plate.points.places.len();
    let middle = all.clone().min_by(|a, b| off(a).total_cmp(&off(b))).unwrap();
    let mut theta = vec![0.0; all.len()];
    theta[middle] = 1.0;
    let total = plate.spread.total(&theta);
    let [cx, cy] = plate.points.places[middle];
    for cycles in [1, 20, 60] {
        plate.advance(&mut theta, cycles);
        assert!(theta.iter().all(|&t| t >= 0.0));
        assert!((plate.spread.total(&theta) / total - 1.0).abs() < 1e-12);
    }
    let moment = |i: usize| {
        let [x, y] = plate.points.places[i];
        plate.spread.capacities[i] * theta[i] * ((x - cx) * (x - cx) + (y - cy) * (y - cy))
    };
    let variance = all.map(moment).sum::<f64>() / total;
    let found = variance / (4.0 * 81.0 * plate.spread.step);
    assert!((found / 1.5 - 1.0).abs() < 0.02, "{found}");
}

/// T5: flux through a square with a slit from its edge to its middle, over that without: 1/√2 by a
/// conformal map. Nothing passes a full cut.
#[test]
fn slits_and_cuts_hold_back_what_they_should() {
    let held = |low: f64, value: f64| SheetSource {
        region: SheetRegion::Box { low: [low, -1.0], high: [low + 0.2, 2.0] },
        from: 0.0,
        until: f64::INFINITY,
        kind: SheetSourceKind::Held(value),
    };
    let flux = |slit: f64| {
        let what = SheetDiffusion { sources: vec![held(-0.2, 1.0), held(1.0, 0.0)], ..paper() };
        let plate = between([-0.1, 1.1], what, vec![vec![[0.5, -0.1], [0.5, slit]]], 1.0 / 30.0);
        let mut theta: Vec<f64> = plate.points.places.iter().map(|p| 1.0 - p[0]).collect();
        plate.advance(&mut theta, 6000);
        let left = |i: &usize| plate.points.places[*i][0] <= 0.0;
        let out = |i: usize| {
            let own =
                plate.spread.of(i).filter(|&n| plate.damage[plate.spread.bonds[n] as usize] < 1.0);
            let pass = |n: usize| {
                plate.spread.weights[n] * (theta[i] - theta[plate.spread.ends[n] as usize])
            };
            own.map(pass).sum::<f64>()
        };
        (0..theta.len()).filter(left).map(out).sum::<f64>()
    };
    let ratio = flux(0.5) / flux(-0.05);
    assert!((ratio / 0.5_f64.sqrt() - 1.0).abs() < 0.03, "{ratio}");
    let what = SheetDiffusion { sources: vec![held(0.0, 1.0)], ..paper() };
    let plate = plate(what, vec![vec![[0.5, -0.1], [0.5, 1.1]]], 1.0 / 30.0);
    let mut theta = vec![0.0; plate.points.places.len()];
    plate.advance(&mut theta, 2000);
    for (theta, place) in theta.iter().zip(&plate.points.places) {
        assert!(if place[0] > 0.5 { *theta == 0.0 } else { *theta > 0.5 });
    }
    assert!(plate.bonds.cut.iter().any(|&cut| cut));
}

/// What comes in from films, fluxes and the air is what the integral grows by; saturation caps it.
#[test]
fn what_comes_in_is_booked() {
    let source = |kind| SheetSource {
        region: SheetRegion::Disc { centre: [0.5, 0.5], radius: 0.2 },
        from: 0.0,
        until: 1.0,
        kind,
    };
    for kind in
        [SheetSourceKind::Held(0.4), SheetSourceKind::Flux(2.0), SheetSourceKind::Film(0.8, 5.0)]
    {
        let what = SheetDiffusion {
            sources: vec![source(kind)],
            saturation: 0.5,
            loss: 0.01,
            ambient: -0.1,
            ..paper()
        };
        let plate = plate(what, vec![], 0.05);
        let mut theta = vec![0.0; plate.points.places.len()];
        let came = plate.advance(&mut theta, 100);
        let total = plate.spread.total(&theta);
        assert!(came != 0.0 && (total - came).abs() < 1e-12 * came.abs().max(1e-3), "{kind:?}");
        assert!(theta.iter().all(|&t| t <= 0.5));
    }
    let rows = [(0.0, 1.0), (0.5, 0.4)];
    assert_eq!([-1.0, 0.25, 2.0].map(|t| share_at(&rows, t)), [1.0, 0.7, 0.4]);
}
