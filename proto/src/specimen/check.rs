//! What a specimen from the wire is held to: numbers that are numbers, indices that name something,
//! counts within their limits. Whether it can be solved the solver says.

use super::{
    Course, Hold, Load, MAX_FRAMES, MAX_PROBES, MAX_SAMPLES, Part, Probe, Push, Setup, Spot, Where,
};
use crate::codec::{self, WireError};
use crate::strength;
use cullet_model::Material;
use cullet_model::strength::Region;

fn bad(what: impl std::fmt::Display) -> WireError {
    WireError::Header(what.to_string())
}

/// An index into a list of `count`.
fn index(what: &'static str, index: u32, count: usize) -> Result<(), WireError> {
    codec::limit(what, u64::from(index) + 1, count as u64)
}

fn part(part: Part) -> Result<(), WireError> {
    match part {
        Part::Axis(k) => codec::limit("the axis of a probe", k.into(), 2),
        Part::Pair(k) => codec::limit("the component of a probe", k.into(), 5),
        _ => Ok(()),
    }
}

/// A direction: its parts over its length are numbers.
fn direction(what: &'static str, v: &[f64]) -> Result<(), WireError> {
    let length = v.iter().map(|c| c * c).sum::<f64>().sqrt();
    codec::finite(what, &v.iter().map(|c| c / length).collect::<Vec<_>>())
}

fn place(part: &Where) -> Result<(), WireError> {
    let what = "a region of a specimen";
    part.iter().try_for_each(|region| match region {
        Region::Box { low, high } => {
            codec::finite(what, &[low.as_slice(), high.as_slice()].concat())
        }
        Region::Sphere { centre, radius } => {
            codec::finite(what, centre.as_slice())?;
            codec::finite(what, &[*radius])
        }
        Region::HalfSpace { point, normal } => {
            codec::finite(what, point.as_slice())?;
            direction(what, normal.as_slice())
        }
        Region::Cylinder { from, to, radius } => {
            codec::finite(what, &[from.as_slice(), to.as_slice()].concat())?;
            codec::finite(what, &[*radius])
        }
    })
}

fn share(what: &str, value: f64) -> Result<(), WireError> {
    let holds = (0.0..=1.0).contains(&value);
    if holds { Ok(()) } else { Err(bad(format!("{what} is {value}; it must lie in [0, 1]"))) }
}

fn material(m: &Material) -> Result<(), WireError> {
    let numbers = [m.density, m.young, m.poisson, m.failure_stress, m.fracture_energy];
    codec::finite("a specimen's material", &numbers)
}

fn course(course: &Course) -> Result<(), WireError> {
    let what = "the course of a load or support";
    match course {
        Course::Table(rows) => {
            rows.iter().try_for_each(|&(time, factor)| codec::finite(what, &[time, factor]))?;
            let falls = rows.windows(2).find(|pair| pair[1].0 < pair[0].0);
            falls.map_or(Ok(()), |pair| {
                let (time, before) = (pair[1].0, pair[0].0);
                Err(bad(format!("{what}: the time {time} s follows {before} s")))
            })
        }
        &Course::HalfSine(start, duration) => {
            codec::finite(what, &[start, duration])?;
            let holds = duration > 0.0;
            if holds { Ok(()) } else { Err(bad(format!("{what} lasts {duration} s"))) }
        }
    }
}

fn hold(hold: &Hold) -> Result<(), WireError> {
    place(&hold.part)?;
    let what = "a support's velocity";
    codec::finite(what, &[hold.velocity, hold.centre].concat())?;
    codec::finite(what, &hold.gradient.concat())?;
    codec::finite("the end of a support", &hold.until.map_or([0.0], |until| [until]))?;
    course(&hold.course)
}

fn load(load: &Load) -> Result<(), WireError> {
    place(&load.part)?;
    match load.push {
        Push::Traction(v) | Push::Force(v) | Push::Acceleration(v) => codec::finite("a load", &v)?,
        Push::Pressure(p) => codec::finite("a load", &[p])?,
    }
    course(&load.course)
}

fn probe(probe: &Probe, setup: &Setup) -> Result<(), WireError> {
    match probe {
        Probe::Points(_, component, Spot::At(x)) => {
            part(*component)?;
            codec::finite("the place of a probe", x)
        }
        Probe::Points(_, component, Spot::Over(region, _)) => {
            part(*component)?;
            place(region)
        }
        Probe::Reaction(support, component) => {
            index("the support of a probe", *support, setup.holds.len())?;
            part(*component)
        }
        Probe::Applied(load, component) => {
            index("the load of a probe", *load, setup.loads.len())?;
            part(*component)
        }
        Probe::Momentum(component) | Probe::AngularMomentum(component) => part(*component),
        Probe::Broken(region) => place(region),
        Probe::DamagedVolume(region, bound) => {
            codec::finite("the bound of a probe", &[*bound])?;
            place(region)
        }
        Probe::CrackArea(region, normal) => {
            direction("the direction of a probe", normal)?;
            place(region)
        }
        Probe::CrackTip(region, along, behind, otherwise) => {
            direction("the direction of a probe", along)?;
            share("the share of a probe", *behind)?;
            codec::finite("the place of a probe", &[*otherwise])?;
            place(region)
        }
        Probe::CrackAngle(region, about, directions) => {
            directions.iter().try_for_each(|v| direction("the direction of a probe", v))?;
            codec::finite("the place of a probe", about)?;
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

fn settings(setup: &Setup) -> Result<(), WireError> {
    let s = &setup.settings;
    let numbers = [s.spacing, s.step_factor, s.per_cell, s.damping, s.max_points, s.max_steps];
    codec::finite("a specimen's settings", &numbers)?;
    let more = [s.softening_length, s.damped_until].map(|number| number.unwrap_or(0.0));
    codec::finite("a specimen's settings", &more)?;
    codec::finite("a specimen's end", &[setup.end])?;
    part(setup.colour.1)
}

/// Holds a setup for a mesh of so many triangles to all that.
pub(super) fn check(setup: &Setup, triangles: u32) -> Result<(), WireError> {
    codec::limit("a specimen's probes", setup.probes.len() as u64, MAX_PROBES)?;
    codec::limit("a specimen's samples", u64::from(setup.samples), MAX_SAMPLES)?;
    codec::limit("a specimen's frames", u64::from(setup.frames), MAX_FRAMES)?;
    strength::check(&setup.strength)?;
    settings(setup)?;
    direction("a specimen's turn", &setup.turn)?;
    codec::finite("a specimen's shift", &setup.shift)?;
    codec::finite("a specimen's displacement gradient", &setup.stretch.concat())?;
    material(&setup.material)?;
    let mut last = 0;
    for &first in &setup.bodies {
        codec::limit("the first triangle of a body", u64::from(first) + 1, triangles.into())?;
        if first <= last {
            return Err(bad(format!("a body begins at triangle {first}, behind {last}")));
        }
        last = first;
    }
    for zone in &setup.zones {
        place(&zone.part)?;
        material(&zone.material)?;
    }
    for patch in &setup.patches {
        place(&patch.part)?;
        codec::finite("the strength of a patch", &[patch.strength])?;
        share("the damage of a patch", patch.damage)?;
    }
    for notch in &setup.notches {
        place(&notch.part)?;
        codec::finite("a notch", &notch.point)?;
        direction("a notch", &notch.normal)?;
    }
    for &(axis, at) in &setup.symmetries {
        codec::limit("the axis of a plane of symmetry", axis.into(), 2)?;
        codec::finite("a plane of symmetry", &[at])?;
    }
    for start in &setup.starts {
        place(&start.part)?;
        codec::finite("a start", &[start.velocity, start.centre, [start.noise; 3]].concat())?;
        codec::finite("a start", &start.gradient.concat())?;
    }
    setup.holds.iter().try_for_each(hold)?;
    setup.loads.iter().try_for_each(load)?;
    setup.probes.iter().try_for_each(|one| probe(one, setup))
}
