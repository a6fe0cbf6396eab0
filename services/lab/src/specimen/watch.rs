//! Probes of a body: names looked up, keys checked against their kinds.

use super::asked;
use super::builder::{SpecimenBuilder, Use};
use super::format::{
    Colour, Component, Expected, Metric, ProbeConfig, ProbeKind, ReduceChoice, SpecimenDocument,
};
use super::paths::{below, item};
use cullet_document::error::suggest;
use cullet_document::tree::Step;
use cullet_geometry::Vec3;
use cullet_specimen as core;
use cullet_specimen::PointField;

/// Damage above which a point counts as damaged \[1\].
const DAMAGED: f64 = 0.05;

/// Share of broken points that may lie ahead of a tip \[1\].
const AHEAD: f64 = 0.02;

/// Least share of a body that counts as a piece \[1\].
const PIECE: f64 = 0.01;

/// What is watched and made of it.
pub(super) struct Watched {
    pub(super) probes: Vec<core::Probe>,
    pub(super) names: Vec<(String, &'static str)>,
    pub(super) speeds: Vec<(usize, f64)>,
    pub(super) metrics: Vec<(Metric, usize)>,
    pub(super) expected: Vec<Option<Expected>>,
}

/// Reads probes, metrics and what is expected of them.
pub(super) fn read(desk: &mut SpecimenBuilder<'_>, document: &SpecimenDocument) -> Watched {
    let mut watched = Watched {
        probes: Vec::new(),
        names: Vec::new(),
        speeds: Vec::new(),
        metrics: Vec::new(),
        expected: Vec::new(),
    };
    for (index, probe) in document.probe.iter().enumerate() {
        let at = item("probe", index);
        keys(desk, probe, &at);
        if let Some(made) = one(desk, document, probe, &at) {
            let speed = probe.kind == ProbeKind::CrackSpeed;
            let window = probe.window.filter(|_| speed);
            watched.speeds.extend(window.map(|window| (watched.probes.len(), window)));
            watched.probes.push(made);
            watched.names.push((probe.name.clone(), unit(probe.kind)));
        }
    }
    let names: Vec<&str> = document.probe.iter().map(|probe| probe.name.as_str()).collect();
    let asked = asked::read(&mut desk.shop, &document.metric, &document.expect, &names);
    (watched.metrics, watched.expected) = asked;
    watched
}

/// The field of points that a kind reads, if it does.
const fn field(kind: ProbeKind) -> Option<PointField> {
    match kind {
        ProbeKind::Displacement => Some(PointField::Displacement),
        ProbeKind::Velocity => Some(PointField::Velocity),
        ProbeKind::Stress => Some(PointField::Stress),
        ProbeKind::Strain => Some(PointField::Strain),
        ProbeKind::Damage => Some(PointField::Damage),
        ProbeKind::PlasticStrain => Some(PointField::PlasticStrain),
        ProbeKind::VolumeRatio => Some(PointField::VolumeRatio),
        _ => None,
    }
}

const fn unit(kind: ProbeKind) -> &'static str {
    if let Some(field) = field(kind) {
        return field.unit();
    }
    match kind {
        ProbeKind::CrackTip => "m",
        ProbeKind::CrackSpeed => "m/s",
        ProbeKind::CrackAngle => "rad",
        ProbeKind::Reaction | ProbeKind::Applied => "N",
        ProbeKind::Kinetic
        | ProbeKind::Elastic
        | ProbeKind::Dissipated
        | ProbeKind::Damped
        | ProbeKind::Contact
        | ProbeKind::Work
        | ProbeKind::Balance => "J",
        ProbeKind::Momentum => "kg m/s",
        ProbeKind::AngularMomentum => "kg m2/s",
        ProbeKind::DamagedVolume => "m3",
        ProbeKind::CrackArea => "m2",
        _ => "1",
    }
}

/// Keys that each kind takes beside `name` and `kind`; those with a star it needs.
const fn takes(kind: ProbeKind) -> &'static [&'static str] {
    match kind {
        ProbeKind::Displacement | ProbeKind::Velocity | ProbeKind::Stress | ProbeKind::Strain => {
            &["component*", "at", "region", "reduce"]
        }
        ProbeKind::Damage | ProbeKind::PlasticStrain | ProbeKind::VolumeRatio => {
            &["at", "region", "reduce"]
        }
        ProbeKind::Reaction => &["support*", "component*"],
        ProbeKind::Applied => &["load*", "component*"],
        ProbeKind::Momentum | ProbeKind::AngularMomentum => &["component*"],
        ProbeKind::Broken => &["region"],
        ProbeKind::DamagedVolume => &["region", "threshold"],
        ProbeKind::CrackArea => &["region", "direction*"],
        ProbeKind::CrackTip => &["region", "direction*", "share", "otherwise"],
        ProbeKind::CrackSpeed => &["region", "direction*", "share", "otherwise", "window*"],
        ProbeKind::CrackAngle => &["region", "at*", "direction*", "towards*"],
        ProbeKind::Pieces => &["share"],
        ProbeKind::Kinetic
        | ProbeKind::Elastic
        | ProbeKind::Dissipated
        | ProbeKind::Damped
        | ProbeKind::Contact
        | ProbeKind::Work
        | ProbeKind::Balance
        | ProbeKind::Largest => &[],
    }
}

fn keys(desk: &mut SpecimenBuilder<'_>, probe: &ProbeConfig, at: &[Step]) {
    let given = [
        ("component", probe.component.is_some()),
        ("at", probe.at.is_some()),
        ("region", probe.region.is_some()),
        ("reduce", probe.reduce.is_some()),
        ("support", probe.support.is_some()),
        ("load", probe.load.is_some()),
        ("threshold", probe.threshold.is_some()),
        ("direction", probe.direction.is_some()),
        ("towards", probe.towards.is_some()),
        ("share", probe.share.is_some()),
        ("otherwise", probe.otherwise.is_some()),
        ("window", probe.window.is_some()),
    ];
    let taken = takes(probe.kind);
    asked::keys(&mut desk.shop, &given, taken, at);
    if taken.contains(&"at")
        && probe.at.is_some()
        && (probe.region.is_some() || probe.reduce.is_some())
    {
        desk.wrong(&below(at, "at"), "takes `at`, or `region` and `reduce`");
    }
}

fn one(
    desk: &mut SpecimenBuilder<'_>,
    document: &SpecimenDocument,
    probe: &ProbeConfig,
    at: &[Step],
) -> Option<core::Probe> {
    let vector = || part(probe.component, false);
    if let Some(field) = field(probe.kind) {
        return points(desk, probe, field, at);
    }
    let made = match probe.kind {
        ProbeKind::Reaction => {
            let names: Vec<&str> = document.support.iter().map(|s| s.name.as_str()).collect();
            let index = named(desk, "support", probe.support.as_deref()?, &names, at)?;
            core::Probe::Reaction(index, checked(desk, vector(), at)?)
        }
        ProbeKind::Applied => {
            let names: Vec<&str> = document.load.iter().map(|s| s.name.as_str()).collect();
            let index = named(desk, "load", probe.load.as_deref()?, &names, at)?;
            core::Probe::Applied(index, checked(desk, vector(), at)?)
        }
        ProbeKind::Kinetic => core::Probe::Kinetic,
        ProbeKind::Elastic => core::Probe::Elastic,
        ProbeKind::Dissipated => core::Probe::Dissipated,
        ProbeKind::Damped => core::Probe::Damped,
        ProbeKind::Contact => core::Probe::Met,
        ProbeKind::Work => core::Probe::Work,
        ProbeKind::Balance => core::Probe::Balance,
        ProbeKind::Momentum => core::Probe::Momentum(checked(desk, vector(), at)?),
        ProbeKind::AngularMomentum => core::Probe::AngularMomentum(checked(desk, vector(), at)?),
        ProbeKind::Broken => core::Probe::Broken(area(desk, probe, at)),
        ProbeKind::DamagedVolume => {
            core::Probe::DamagedVolume(area(desk, probe, at), probe.threshold.unwrap_or(DAMAGED))
        }
        ProbeKind::CrackArea => {
            let along = desk.unit(probe.direction?, &below(at, "direction"));
            core::Probe::CrackArea(area(desk, probe, at), along)
        }
        ProbeKind::CrackTip | ProbeKind::CrackSpeed => {
            let along = desk.unit(probe.direction?, &below(at, "direction"));
            let behind = 1.0 - probe.share.unwrap_or(AHEAD);
            let otherwise = probe.otherwise.unwrap_or(0.0);
            core::Probe::CrackTip { part: area(desk, probe, at), along, share: behind, otherwise }
        }
        ProbeKind::CrackAngle => {
            let first = desk.unit(probe.direction?, &below(at, "direction"));
            let second = desk.unit(probe.towards?, &below(at, "towards"));
            core::Probe::CrackAngle(area(desk, probe, at), Vec3::from(probe.at?), [first, second])
        }
        ProbeKind::Pieces => core::Probe::Pieces(probe.share.unwrap_or(PIECE)),
        ProbeKind::Largest => core::Probe::Largest,
        ProbeKind::Displacement
        | ProbeKind::Velocity
        | ProbeKind::Stress
        | ProbeKind::Strain
        | ProbeKind::Damage
        | ProbeKind::PlasticStrain
        | ProbeKind::VolumeRatio => return None,
    };
    Some(made)
}

fn area(desk: &mut SpecimenBuilder<'_>, probe: &ProbeConfig, at: &[Step]) -> core::Where {
    desk.region(probe.region.as_deref().unwrap_or("all"), at, Use::Points)
}

fn points(
    desk: &mut SpecimenBuilder<'_>,
    probe: &ProbeConfig,
    field: PointField,
    at: &[Step],
) -> Option<core::Probe> {
    let tensor = field.is_tensor();
    let part = match field.is_number() {
        true => core::TensorPart::Size,
        false => checked(desk, part(probe.component, tensor), at)?,
    };
    let spot = match probe.at {
        Some(place) => core::Spot::At(Vec3::from(place)),
        None => {
            let reduce = match probe.reduce.unwrap_or_default() {
                ReduceChoice::Mean => core::Reduce::Mean,
                ReduceChoice::Max => core::Reduce::Max,
                ReduceChoice::Min => core::Reduce::Min,
            };
            core::Spot::Over(area(desk, probe, at), reduce)
        }
    };
    Some(core::Probe::Points(field, part, spot))
}

fn checked(
    desk: &mut SpecimenBuilder<'_>,
    part: Result<core::TensorPart, &'static str>,
    at: &[Step],
) -> Option<core::TensorPart> {
    part.map_err(|why| desk.wrong(&below(at, "component"), why)).ok()
}

pub(super) fn part(
    component: Option<Component>,
    tensor: bool,
) -> Result<core::TensorPart, &'static str> {
    let Some(component) = component else {
        // Said already: the kind needs one.
        return Ok(core::TensorPart::Size);
    };
    let axis = |k| {
        if tensor {
            Err("a tensor has xx, yy, zz, xy, yz, zx")
        } else {
            Ok(core::TensorPart::Axis(k))
        }
    };
    let vector = Err("a vector has x, y, z and size");
    let pair = |k| if tensor { Ok(core::TensorPart::Pair(k)) } else { vector };
    let whole = |part| if tensor { Ok(part) } else { vector };
    match component {
        Component::X => axis(0),
        Component::Y => axis(1),
        Component::Z => axis(2),
        Component::Size => Ok(core::TensorPart::Size),
        Component::Xx => pair(0),
        Component::Yy => pair(1),
        Component::Zz => pair(2),
        Component::Xy => pair(3),
        Component::Yz => pair(4),
        Component::Zx => pair(5),
        Component::Greatest => whole(core::TensorPart::Greatest),
        Component::Least => whole(core::TensorPart::Least),
        Component::Mises => whole(core::TensorPart::Mises),
        Component::Mean => whole(core::TensorPart::Mean),
    }
}

fn named(
    desk: &mut SpecimenBuilder<'_>,
    key: &str,
    name: &str,
    names: &[&str],
    at: &[Step],
) -> Option<u32> {
    let found = names.iter().position(|known| *known == name);
    if found.is_none() {
        let message = format!("there is no {key} \"{name}\"");
        desk.shop.wrong_with(&below(at, key), message, suggest(name, names));
    }
    found.map(|index| index as u32)
}

/// What colours the points of a recording.
pub(super) const fn colour(colour: Colour) -> (PointField, core::TensorPart) {
    match colour {
        Colour::Damage => (PointField::Damage, core::TensorPart::Size),
        Colour::Stress => (PointField::Stress, core::TensorPart::Greatest),
        Colour::Speed => (PointField::Velocity, core::TensorPart::Size),
        Colour::Displacement => (PointField::Displacement, core::TensorPart::Size),
        Colour::PlasticStrain => (PointField::PlasticStrain, core::TensorPart::Size),
    }
}
