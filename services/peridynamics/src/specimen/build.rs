//! From a specimen to points and bonds.

use super::mirror::{MirrorSet, unfit};
use crate::bonds::BondError;
use crate::domain::PeridynamicDomain;
use crate::law::{BondBreaking, PartedContact, PeridynamicLaw};
use cullet_geometry::inside::Inside;
use cullet_geometry::{Pose, Vec3};
use cullet_model::{Refusal, Strength};
use cullet_specimen::{
    GridFrame, Notch, PointLayout, Probe, SpecimenProblem, Spot, Where, filling, idle, within,
};
use std::cell::Cell;

/// Horizon over the spacing where a specimen names none \[1\].
pub const HORIZON: f64 = 3.015;

/// Horizons that the weights of bonds were looked at for \[spacings\].
const HORIZONS: [f64; 2] = [1.5, 6.0];

/// Spacings from the nearest point at which a probe still reads the body.
const FAR: f64 = 2.0;

fn range(what: &'static str, value: f64, [low, high]: [f64; 2]) -> Result<(), Refusal> {
    let holds = (low..=high).contains(&value);
    if holds { Ok(()) } else { Err(Refusal::OutOfRange { what, value, low, high }) }
}

/// Horizon over the spacing \[1\].
pub(super) fn horizon(specimen: &SpecimenProblem) -> f64 {
    specimen.settings.horizon.unwrap_or(HORIZON)
}

/// Refuses what cannot be solved, with the bound.
pub(super) fn check(specimen: &SpecimenProblem) -> Result<(), Refusal> {
    let (s, m) = (&specimen.settings, &specimen.matter.material);
    range("the horizon over the spacing", horizon(specimen), HORIZONS)?;
    range("density [kg/m^3]", m.density, [1e-3, 1e6])?;
    range("Young's modulus [Pa]", m.young, [1.0, 1e14])?;
    range("Poisson's ratio", m.poisson, [-0.5, 0.49])?;
    if s.breaks {
        range("fracture energy [J/m^2]", m.fracture_energy, [1e-9, 1e12])?;
    }
    if let Some(plane) = specimen.matter.strength.weak_plane {
        range("strength across a weak plane, of bonds", plane.ratio, [1.0, 1.0])?;
    }
    for patch in &specimen.matter.patches {
        range("damage of a patch, of bonds", patch.damage, [0.0, 0.0])?;
    }
    if specimen.matter.flow.is_some_and(|flow| flow.rate != 0.0 || flow.softening.is_some()) {
        return Err(unfit("points flow alike at any rate and temperature".to_owned()));
    }
    let points = specimen.body.mesh.signed_volume() / (s.spacing * s.spacing * s.spacing);
    let what = "the number of points";
    let over = points > s.max_points;
    if over { Err(Refusal::TooLarge { what, value: points, limit: s.max_points }) } else { Ok(()) }
}

/// Fills the body with points, in the specimen's frame, behind them the images that planes make.
fn filled(
    specimen: &SpecimenProblem,
    frame: &GridFrame,
    mirrors: &mut MirrorSet,
) -> Result<Vec<Vec3>, Refusal> {
    let s = &specimen.settings;
    let h = s.spacing;
    let pose = Pose::from_parts(specimen.body.shift.into(), specimen.body.turn);
    let inside = Inside::new(&specimen.body.mesh.transformed(&pose));
    let offset = mirrors.row_offset(specimen, frame);
    let mut places = filling::points(&inside, h, offset, s)?;
    if s.points.layout == PointLayout::Scattered {
        // Neighbours near each other in the list.
        let reach = h * horizon(specimen);
        places.sort_by_cached_key(|x| [0, 1, 2].map(|a| (x[a] / reach).floor() as i64));
    }
    let mut places: Vec<Vec3> = places.iter().map(|x| frame.back(x)).collect();
    mirrors.images(specimen, 2.0 * h * horizon(specimen), &mut places)?;
    Ok(places)
}

/// What it is made of.
fn law(specimen: &SpecimenProblem) -> PeridynamicLaw {
    let (m, breaks) = (&specimen.matter.material, specimen.settings.breaks);
    let flow = specimen.matter.flow;
    let breaking = BondBreaking { fracture_energy: m.fracture_energy, dust: 0.0 };
    let parts = breaks || !specimen.initial.notches.is_empty();
    PeridynamicLaw {
        hardening: flow.map(|flow| flow.hardening),
        breaking: breaks.then_some(breaking),
        ductile: flow.filter(|_| breaks).and_then(|flow| flow.failure),
        contact: parts.then_some(PartedContact { friction: 0.0 }),
        ..PeridynamicLaw::elastic(m.density, m.young, m.poisson)
    }
}

/// The body at rest, with its notches, and its images.
pub(super) fn domain(
    specimen: &SpecimenProblem,
    frame: &GridFrame,
    mirrors: &mut MirrorSet,
) -> Result<PeridynamicDomain, Refusal> {
    let places = filled(specimen, frame, mirrors)?;
    let own = places.len() - mirrors.len();
    taken(specimen, &places[..own])?;
    let volume = specimen.body.mesh.signed_volume() / own as f64;
    let reach = horizon(specimen) * specimen.settings.spacing;
    let onto = places.iter().map(|x| frame.onto(x)).collect();
    let bonded = PeridynamicDomain::new(onto, vec![volume; places.len()], reach, law(specimen));
    let mut domain = bonded.map_err(|why: BondError| unfit(why.to_string()))?;
    domain.own = own;
    if specimen.settings.breaks {
        let unfolded: Vec<Vec3> = places.iter().map(|x| mirrors.unfolded(x)).collect();
        domain.strengthen(&strengths(specimen, &unfolded));
    }
    let slack = 1e-9 * specimen.settings.spacing;
    let back = |x: &Vec3| mirrors.unfolded(&frame.back(x));
    let mut cut = Vec::new();
    for notch in &specimen.initial.notches {
        let some = Cell::new(false);
        domain.sever(|a, b| {
            let crosses = crosses(notch, [&back(a), &back(b)], slack);
            some.set(some.get() || crosses);
            crosses
        });
        cut.push(!some.get());
    }
    idle("notch", cut.into_iter())?;
    Ok(domain)
}

/// Displaces it and sets it going as it starts.
pub(super) fn launch(
    specimen: &SpecimenProblem,
    frame: &GridFrame,
    domain: &mut PeridynamicDomain,
) {
    let stretch = specimen.initial.stretch;
    let seed = specimen.settings.seed;
    for (place, velocity) in domain.places.iter_mut().zip(&mut domain.velocities) {
        let x = frame.back(place);
        let starts = specimen.initial.starts.iter().filter(|start| within(&start.part, &x, 0.0));
        *velocity = frame.turned(&starts.map(|start| start.at(&x, seed)).sum());
        *place += frame.turned(&(stretch * x));
    }
    domain.strain();
}

fn strengths(specimen: &SpecimenProblem, places: &[Vec3]) -> Vec<f64> {
    let field = Strength::new(&specimen.matter.strength, specimen.settings.spacing);
    let patches = &specimen.matter.patches;
    let of = |x: &Vec3| {
        let here = patches.iter().filter(|patch| within(&patch.part, x, 0.0));
        field.factor(x) * here.map(|patch| patch.strength).product::<f64>()
    };
    places.iter().map(of).collect()
}

/// Refuses patches, starts and places of probes that take none of the points.
fn taken(specimen: &SpecimenProblem, places: &[Vec3]) -> Result<(), Refusal> {
    let none = |part: &Where| !places.iter().any(|x| within(part, x, 0.0));
    idle("patch", specimen.matter.patches.iter().map(|patch| none(&patch.part)))?;
    let starts = specimen.initial.starts.iter();
    idle("start", starts.map(|start| !start.is_none() && none(&start.part)))?;
    let near = FAR * specimen.settings.spacing;
    let away = |probe: &Probe| match probe {
        Probe::Points(_, _, Spot::At(x)) => !places.iter().any(|at| (at - x).norm() <= near),
        _ => false,
    };
    idle("probe", specimen.output.probes.iter().map(away))
}

/// Whether a notch lies between two places of the specimen, whichever comes first.
fn crosses(notch: &Notch, [a, b]: [&Vec3; 2], slack: f64) -> bool {
    let [first, second] = [a, b].map(|x| (x - notch.point).dot(&notch.normal));
    if (first >= 0.0) == (second >= 0.0) {
        return false;
    }
    // From the same end, whichever asks.
    let (x, y, at, to) = match first > second {
        true => (a, b, first, second),
        false => (b, a, second, first),
    };
    within(&notch.part, &(x + (y - x) * (at / (at - to))), slack)
}

/// Stress at which a bar begins to tear over σ_f: bonds along it soften from s_c/2 \[1\].
pub(super) fn strength_ratio(domain: &PeridynamicDomain, specimen: &SpecimenProblem) -> f64 {
    let m = &specimen.matter.material;
    let ratio = 0.5 * m.young * domain.critical / m.failure_stress;
    if specimen.settings.breaks { ratio.min(1.0) } else { 1.0 }
}
