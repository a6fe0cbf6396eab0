//! What a specimen from the wire is held to: numbers that are numbers, indices that name something,
//! counts within their limits. Whether it can be solved the family says.

use crate::bounds::{MAX_FAMILY, MAX_FRAMES, MAX_PROBES, MAX_SAMPLES};
use crate::codec::{self, WireError};
use cullet_geometry::{Mat3, Vec3};
use cullet_model::strength::Region;
use cullet_model::{Material, StrengthField};
use cullet_specimen::{
    Amplitude, Hold, Load, LoadKind, Matter, Output, Probe, SpecimenProblem, Spot, TensorPart,
    Where,
};

fn bad(what: impl std::fmt::Display) -> WireError {
    WireError::Header(what.to_string())
}

/// An index into a list of `count`.
fn index(what: &'static str, index: u32, count: usize) -> Result<(), WireError> {
    codec::limit(what, u64::from(index) + 1, count as u64)
}

fn part(part: TensorPart) -> Result<(), WireError> {
    match part {
        TensorPart::Axis(k) => codec::limit("the axis of a probe", k.into(), 2),
        TensorPart::Pair(k) => codec::limit("the component of a probe", k.into(), 5),
        _ => Ok(()),
    }
}

fn vector(what: &'static str, v: &Vec3) -> Result<(), WireError> {
    codec::finite(what, v.as_slice())
}

fn matrix(what: &'static str, m: &Mat3) -> Result<(), WireError> {
    codec::finite(what, m.as_slice())
}

/// A direction: its parts over its length are numbers.
fn direction(what: &'static str, v: &[f64]) -> Result<(), WireError> {
    let length = v.iter().map(|c| c * c).sum::<f64>().sqrt();
    codec::finite(what, &v.iter().map(|c| c / length).collect::<Vec<_>>())
}

fn region(region: &Region) -> Result<(), WireError> {
    let what = "a region of a specimen";
    match region {
        Region::Box { low, high } => vector(what, low).and_then(|()| vector(what, high)),
        Region::Sphere { centre, radius } => {
            vector(what, centre)?;
            codec::finite(what, &[*radius])
        }
        Region::HalfSpace { point, normal } => {
            vector(what, point)?;
            direction(what, normal.as_slice())
        }
        Region::Groove { from, to, inward, half_width } => {
            [from, to, inward].into_iter().try_for_each(|place| vector(what, place))?;
            codec::finite(what, &[*half_width])
        }
        Region::Cylinder { from, to, radius } => {
            vector(what, from)?;
            vector(what, to)?;
            codec::finite(what, &[*radius])
        }
    }
}

fn place(part: &Where) -> Result<(), WireError> {
    part.iter().try_for_each(region)
}

fn share(what: &str, value: f64) -> Result<(), WireError> {
    let holds = (0.0..=1.0).contains(&value);
    if holds { Ok(()) } else { Err(bad(format!("{what} is {value}; it must lie in [0, 1]"))) }
}

fn material(m: &Material) -> Result<(), WireError> {
    let numbers = [m.density, m.young, m.poisson, m.failure_stress, m.fracture_energy];
    codec::finite("a specimen's material", &numbers)
}

fn strength(field: &StrengthField) -> Result<(), WireError> {
    let what = "a specimen's strength";
    crate::strength::check(field, ("a specimen's painted regions", what))?;
    if let Some(weak) = &field.weak_plane {
        direction(what, weak.normal.as_slice())?;
    }
    if let Some(layers) = &field.layers {
        direction(what, layers.normal.as_slice())?;
    }
    field.strokes.iter().try_for_each(|stroke| region(&stroke.region))?;
    let painted = field.vertices.is_some();
    if painted { Err(bad("a specimen has no paint on its surface")) } else { Ok(()) }
}

fn course(course: &Amplitude) -> Result<(), WireError> {
    let what = "the course of a load or support";
    match course {
        Amplitude::Table(rows) => {
            rows.iter().try_for_each(|&(time, factor)| codec::finite(what, &[time, factor]))?;
            let falls = rows.windows(2).find(|pair| pair[1].0 < pair[0].0);
            falls.map_or(Ok(()), |pair| {
                let (time, before) = (pair[1].0, pair[0].0);
                Err(bad(format!("{what}: the time {time} s follows {before} s")))
            })
        }
        &Amplitude::HalfSine { start, duration } => {
            codec::finite(what, &[start, duration])?;
            let holds = duration > 0.0;
            if holds { Ok(()) } else { Err(bad(format!("{what} lasts {duration} s"))) }
        }
    }
}

fn hold(hold: &Hold) -> Result<(), WireError> {
    place(&hold.part)?;
    let what = "a support's velocity";
    vector(what, &hold.velocity)?;
    vector(what, &hold.centre)?;
    matrix(what, &hold.gradient)?;
    codec::finite("the end of a support", &hold.until.map_or([0.0], |until| [until]))?;
    course(&hold.course)
}

fn load(load: &Load) -> Result<(), WireError> {
    place(&load.part)?;
    match &load.push {
        LoadKind::Traction(v) | LoadKind::Force(v) | LoadKind::Acceleration(v) => {
            vector("a load", v)?;
        }
        LoadKind::Pressure(p) => codec::finite("a load", &[*p])?,
    }
    course(&load.course)
}

fn probe(probe: &Probe, problem: &SpecimenProblem) -> Result<(), WireError> {
    let axis = "the direction of a probe";
    match probe {
        Probe::Points(_, component, Spot::At(x)) => {
            part(*component)?;
            vector("the place of a probe", x)
        }
        Probe::Points(_, component, Spot::Over(region, _)) => {
            part(*component)?;
            place(region)
        }
        Probe::Reaction(support, component) => {
            index("the support of a probe", *support, problem.holds.len())?;
            part(*component)
        }
        Probe::Applied(load, component) => {
            index("the load of a probe", *load, problem.loads.len())?;
            part(*component)
        }
        Probe::Momentum(component) | Probe::AngularMomentum(component) => part(*component),
        Probe::Broken(region) => place(region),
        Probe::DamagedVolume(region, bound) => {
            codec::finite("the bound of a probe", &[*bound])?;
            place(region)
        }
        Probe::CrackArea(region, normal) => {
            direction(axis, normal.as_slice())?;
            place(region)
        }
        Probe::CrackTip { part: region, along, share: behind, otherwise } => {
            direction(axis, along.as_slice())?;
            share("the share of a probe", *behind)?;
            codec::finite("the place of a probe", &[*otherwise])?;
            place(region)
        }
        Probe::CrackAngle(region, about, directions) => {
            directions.iter().try_for_each(|v| direction(axis, v.as_slice()))?;
            vector("the place of a probe", about)?;
            place(region)
        }
        Probe::Pieces(least) => share("the share of a probe", *least),
        Probe::Kinetic
        | Probe::Elastic
        | Probe::Dissipated
        | Probe::Damped
        | Probe::Met
        | Probe::Work
        | Probe::Balance
        | Probe::Largest => Ok(()),
    }
}

fn settings(problem: &SpecimenProblem) -> Result<(), WireError> {
    let (s, points) = (&problem.settings, &problem.settings.points);
    let numbers = [s.spacing, s.step_factor, points.per_cell, s.damping, s.max_points, s.max_steps];
    codec::finite("a specimen's settings", &numbers)?;
    let more = [points.softening_length, s.damped_until, s.horizon];
    let more = more.map(|number| number.unwrap_or(0.0));
    codec::finite("a specimen's settings", &more)
}

fn output(output: &Output) -> Result<(), WireError> {
    codec::limit("a specimen's probes", output.probes.len() as u64, MAX_PROBES)?;
    codec::limit("a specimen's samples", u64::from(output.samples), MAX_SAMPLES)?;
    codec::limit("a specimen's frames", u64::from(output.frames), MAX_FRAMES)?;
    codec::finite("a specimen's end", &[output.end])?;
    part(output.colour.1)
}

fn matter(matter: &Matter) -> Result<(), WireError> {
    strength(&matter.strength)?;
    material(&matter.material)?;
    for zone in &matter.zones {
        place(&zone.part)?;
        material(&zone.material)?;
    }
    for patch in &matter.patches {
        place(&patch.part)?;
        codec::finite("the strength of a patch", &[patch.strength])?;
        share("the damage of a patch", patch.damage)?;
    }
    Ok(())
}

fn body(problem: &SpecimenProblem, triangles: u32) -> Result<(), WireError> {
    let body = &problem.body;
    direction("a specimen's turn", body.turn.coords.as_slice())?;
    vector("a specimen's shift", &body.shift)?;
    let mut last = 0;
    for &first in &body.parts {
        codec::limit("the first triangle of a body", u64::from(first) + 1, triangles.into())?;
        if first <= last {
            return Err(bad(format!("a body begins at triangle {first}, behind {last}")));
        }
        last = first;
    }
    Ok(())
}

fn initial(problem: &SpecimenProblem) -> Result<(), WireError> {
    let initial = &problem.initial;
    matrix("a specimen's displacement gradient", &initial.stretch)?;
    for notch in &initial.notches {
        place(&notch.part)?;
        vector("a notch", &notch.point)?;
        direction("a notch", notch.normal.as_slice())?;
    }
    for start in &initial.starts {
        place(&start.part)?;
        vector("a start", &start.velocity)?;
        vector("a start", &start.centre)?;
        matrix("a start", &start.gradient)?;
        codec::finite("a start", &[start.noise])?;
    }
    Ok(())
}

/// Holds a problem for a mesh of so many triangles to all that.
pub(super) fn check(problem: &SpecimenProblem, triangles: u32) -> Result<(), WireError> {
    codec::limit("the name of a specimen's family", problem.family.len() as u64, MAX_FAMILY)?;
    output(&problem.output)?;
    settings(problem)?;
    body(problem, triangles)?;
    matter(&problem.matter)?;
    initial(problem)?;
    for plane in &problem.symmetries {
        codec::limit("the axis of a plane of symmetry", plane.axis.into(), 2)?;
        codec::finite("a plane of symmetry", &[plane.at])?;
    }
    problem.holds.iter().try_for_each(hold)?;
    problem.loads.iter().try_for_each(load)?;
    problem.output.probes.iter().try_for_each(|one| probe(one, problem))
}
