//! What a window looks at as it ends: figures of what can go wrong with a sheet, and warnings where
//! they are beyond their bounds. docs/failures.md has the modes.

use crate::law::generalised;
use crate::steps::SheetRun;
use cullet_continuum::air;
use cullet_model::{MembraneLaw, MembranePace, Proxy, ProxyMotion};

/// Mean overshoot of breaking bonds above which a warning is given (F80m).
const MOST_OVERSHOOT: f64 = 1.03;
/// Share of the energy in bonds that soften, likewise (F81m).
const MOST_SOFTENING: f64 = 0.15;
/// Mean stretch of a softer sheet, likewise (F92m).
const MOST_STRETCH: f64 = 0.05;
/// Share of a point's velocity that drag takes in a step, likewise (F94m).
const MOST_DRAG: f64 = 0.5;
/// Mass of a body over that of the sheet above which their contact is said to be a hard one (F91m).
const HEAVY: f64 = 1e3;

/// A figure: name, unit, value.
pub(crate) type NamedFigure = (&'static str, &'static str, f64);

/// What the bonds and points of a sheet are like.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(crate) struct SheetCondition {
    /// Share of the energy of bonds that is in those that soften \[1\] (F81m).
    pub(crate) softening: f64,
    /// Mean of g over bonds, by stiffness, root of squares \[1\] (F92m).
    pub(crate) stretch: f64,
    /// Share of points that do not bend \[1\] (F88m).
    pub(crate) limp: f64,
    /// Area over that at rest \[1\] (F89m).
    pub(crate) area: f64,
}

impl SheetCondition {
    /// As a run has come to it.
    pub(crate) fn of(run: &SheetRun) -> Self {
        let [softening, stretch] = of_bonds(run);
        let areas = &run.prepared.points.areas;
        let (mut limp, mut now, mut rest) = (0.0, 0.0, 0.0);
        let here = run.gone.iter().filter(|gone| !**gone).count();
        for (i, at_rest) in areas.iter().enumerate().filter(|&(i, _)| !run.gone[i]) {
            let bends = |n: usize| run.stencils.terms[n].curvature != [0.0; 3];
            if run.prepared.bending > 0.0 && !run.stencils.of(i).any(bends) {
                limp += 1.0;
            }
            let [x, y] = run.stencils.slopes(i, &run.state.places);
            let area = x.cross(&y).norm() * at_rest;
            if area > 0.0 {
                now += area;
                rest += at_rest;
            }
        }
        let limp = limp / here.max(1) as f64;
        let area = if rest > 0.0 { now / rest } else { 1.0 };
        Self { softening, stretch, limp, area }
    }
}

/// Greatest share of a point's velocity that drag would take in a step, now \[1\] (F94m).
pub(crate) fn drag_share(run: &SheetRun) -> f64 {
    let (prepared, state) = (&run.prepared, &run.state);
    let air = &prepared.sheet().air;
    if !air::acts(air) {
        return 0.0;
    }
    let time = state.step as f64 * prepared.setup.world_step;
    let wind = air::wind(air, prepared.setup.seed, time);
    let of = |i: usize| {
        let [x, y] = run.stencils.slopes(i, &state.places);
        let area = x.cross(&y) * prepared.points.areas[i];
        let relative = state.velocities[i] - wind;
        air::drag_share(air, area, relative, run.masses[i][1], prepared.step())
    };
    (0..state.places.len()).filter(|&i| !run.gone[i]).map(of).fold(0.0, f64::max)
}

/// Share of the energy in bonds that soften, and mean stretch.
fn of_bonds(run: &SheetRun) -> [f64; 2] {
    let (bonds, state, table) = (&run.prepared.bonds, &run.state, &run.table);
    let law = run.prepared.sheet().material.law;
    let (mut soft, mut all, mut square, mut stiffness) = (0.0, 0.0, 0.0, 0.0);
    for i in (0..state.places.len()).filter(|&i| !run.gone[i]) {
        for b in bonds.of(i).filter(|&b| bonds.ends[b] as usize > i) {
            let memory = state.memory(b);
            if memory.damage >= 1.0 {
                continue;
            }
            let length = (state.places[bonds.ends[b] as usize] - state.places[i]).norm();
            let g = generalised(law, length * table.rest[b]);
            let k = table.stiffness[b];
            let left = if g > 0.0 { 1.0 - memory.damage } else { 1.0 };
            let energy = k * left * (g - memory.plastic) * (g - memory.plastic);
            let limits = table.limits[b];
            let even = limits.critical * limits.critical / (3.0 * limits.first);
            if memory.damage > 0.0 || memory.flowed > even {
                soft += energy;
            }
            all += energy;
            square += k * g * g;
            stiffness += k;
        }
    }
    let over = |a: f64, b: f64| if b > 0.0 { a / b } else { 0.0 };
    [over(soft, all), over(square, stiffness).sqrt()]
}

/// What a window has seen on its way.
#[derive(Clone, Copy, Debug, Default)]
pub(crate) struct WindowExtremes {
    /// Most places of a frame at which the sheet goes through itself (F95m).
    pub(crate) crossed: usize,
    /// Greatest [`drag_share`] at its start and at the ends of steps of the world.
    pub(crate) drag: f64,
}

/// Figures that a window reports beside its ledger.
pub(crate) fn figures(
    run: &SheetRun,
    condition: &SheetCondition,
    seen: WindowExtremes,
) -> Vec<NamedFigure> {
    let prepared = &run.prepared;
    let first = prepared.limits().first;
    let work = prepared.sheet().material.fracture_energy;
    vec![
        ("break_overshoot", "1", run.watch.overshoot()),
        ("process_zone", "m", work / (prepared.pace.young * first * first)),
        ("softening_share", "1", condition.softening),
        ("ties_dropped", "1", run.watch.ties as f64),
        ("edges_without_bonds", "1", prepared.edges_without_bonds() as f64),
        ("share_without_bending", "1", condition.limp),
        ("area_ratio", "1", condition.area),
        ("mean_stretch", "1", condition.stretch),
        ("drag_share", "1", seen.drag),
        ("crossings", "1", seen.crossed as f64),
    ]
}

/// What of it the reader should know.
pub(crate) fn warnings(
    run: &SheetRun,
    condition: &SheetCondition,
    seen: WindowExtremes,
) -> Vec<String> {
    let mut warnings = of_breaks(run, condition);
    let (prepared, sheet) = (&run.prepared, run.prepared.sheet());
    let softer = matches!(sheet.pace, MembranePace::Softer(_)) && prepared.pace.stretches > 1.0;
    if softer && sheet.material.law != MembraneLaw::Rubber && condition.stretch > MOST_STRETCH {
        warnings.push(format!(
            "the softer sheet is stretched by {:.3} in the mean, more than {MOST_STRETCH}: take a \
             faster pace",
            condition.stretch
        ));
    }
    if seen.drag > MOST_DRAG {
        warnings.push(format!(
            "drag would take {:.2} of a point's velocity in a step: what it takes implicitly is \
             less than it should be; take a faster pace",
            seen.drag
        ));
    }
    if seen.crossed > 0 {
        warnings.push(format!(
            "the sheet goes through itself: {} edges between points through triangles; it \
             is not frozen while it does",
            seen.crossed
        ));
    }
    if prepared.edges_without_bonds() > 0 {
        warnings.push(format!(
            "edges of the drawn surface without a bond: {}; they look torn, for the outline is \
             finer than the spacing there",
            prepared.edges_without_bonds()
        ));
    }
    warnings
}

fn of_breaks(run: &SheetRun, condition: &SheetCondition) -> Vec<String> {
    let mut warnings = Vec::new();
    let overshoot = run.watch.overshoot();
    if overshoot > MOST_OVERSHOOT {
        warnings.push(format!(
            "bonds broke at {overshoot:.3} of the stretch at which they should, in the mean: what \
             tears is faster than the steps, and costs too much"
        ));
    }
    if condition.softening > MOST_SOFTENING {
        warnings.push(format!(
            "bonds that soften hold {:.2} of what is stored, more than {MOST_SOFTENING}: the zone \
             in which a crack forms is not small beside the sheet; take a finer spacing",
            condition.softening
        ));
    }
    let first = run.watch.first.unwrap_or_default();
    if let Some(grip) = first.grip {
        warnings.push(format!(
            "the first bond broke within a horizon of the strip around grip {grip} in which \
             nothing breaks: the grip decides where it tears; load it more slowly, or notch it"
        ));
    }
    if let Some(front) = first.front {
        warnings.push(format!(
            "the first bond broke where what spreads had come {front:.2e} m, less than three \
             spacings: rows part along its source; let it come in through a film, more slowly, or \
             take a finer spacing"
        ));
    }
    warnings
}

/// That points of a sheet of this mass \[kg\] were deeper in a body than contact should let them:
/// by more than the distance \[m\] from which it pushes.
pub(crate) fn pressed_through(
    proxy: &Proxy,
    depth: f64,
    contact: f64,
    mass: f64,
) -> Option<String> {
    if depth <= 2.0 * contact {
        return None;
    }
    let body = proxy.body;
    let heavy = mass_ratio(proxy, mass).filter(|ratio| *ratio > HEAVY).map(|ratio| {
        format!(
            ", which has {ratio:.1e} times the sheet's mass: take a faster pace, or a lighter body"
        )
    });
    let heavy = heavy.unwrap_or_default();
    Some(format!("points were {:.3e} m inside of body {body}{heavy}", depth - contact))
}

/// Mass of a body that moves freely over that of a sheet.
pub(crate) fn mass_ratio(proxy: &Proxy, sheet: f64) -> Option<f64> {
    match proxy.motion {
        ProxyMotion::Free { mass, .. } if sheet > 0.0 => Some(mass / sheet),
        _ => None,
    }
}
