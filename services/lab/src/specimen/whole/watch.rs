//! Probes of the whole: names of bodies looked up, keys held against their kinds.

use super::super::asked;
use super::super::paths::item;
use super::super::watch::part;
use super::format::{Probe, ProbeKind};
use cullet_document::error::suggest;
use cullet_document::tree::{Step, join};
use cullet_scene::context::ResolveContext;
use cullet_scene::{Scene, SceneBody};
use cullet_specimen::TensorPart;
use std::collections::BTreeSet;

/// A probe with its names looked up.
#[derive(Clone, Debug, PartialEq)]
pub struct Watch {
    /// What it watches.
    pub kind: ProbeKind,
    /// The bodies of the scene that it is about; all that are not fixed without any.
    pub bodies: Option<BTreeSet<String>>,
    /// What hits them; anything without any.
    pub others: Option<BTreeSet<String>>,
    /// Which number of a vector or tensor.
    pub part: TensorPart,
    /// Which of the hits, from 0.
    pub nth: usize,
    /// Least share of the mass that counts \[1\].
    pub share: f64,
}

/// Keys that each kind takes beside `name` and `kind`; those with a star it needs.
const fn takes(kind: ProbeKind) -> &'static [&'static str] {
    match kind {
        ProbeKind::Position | ProbeKind::Velocity | ProbeKind::Spin | ProbeKind::Inertia => {
            &["body*", "component*"]
        }
        ProbeKind::Displacement | ProbeKind::Momentum | ProbeKind::AngularMomentum => {
            &["body", "component*"]
        }
        ProbeKind::Balance => &[],
        ProbeKind::Pieces => &["body*", "share"],
        ProbeKind::Largest => &["body*"],
        ProbeKind::Hits => &["body", "other"],
        ProbeKind::HitOrder
        | ProbeKind::HitTime
        | ProbeKind::HitSpeed
        | ProbeKind::HitImpulse
        | ProbeKind::HitEnergy
        | ProbeKind::HitTook
        | ProbeKind::HitMass
        | ProbeKind::HitDuration
        | ProbeKind::HitRadius
        | ProbeKind::HitForce => &["body*", "other", "nth"],
        _ => &["body"],
    }
}

pub(super) const fn unit(kind: ProbeKind) -> &'static str {
    match kind {
        ProbeKind::Position | ProbeKind::Displacement | ProbeKind::HitRadius => "m",
        ProbeKind::Velocity | ProbeKind::HitSpeed => "m/s",
        ProbeKind::Spin => "rad/s",
        ProbeKind::Mass | ProbeKind::HitMass => "kg",
        ProbeKind::Volume => "m3",
        ProbeKind::Inertia => "kg m2",
        ProbeKind::Momentum => "kg m/s",
        ProbeKind::AngularMomentum => "kg m2/s",
        ProbeKind::HitTime | ProbeKind::HitDuration => "s",
        ProbeKind::HitImpulse => "N s",
        ProbeKind::HitForce => "N",
        ProbeKind::Kinetic
        | ProbeKind::Potential
        | ProbeKind::Energy
        | ProbeKind::HitLoss
        | ProbeKind::BreakLoss
        | ProbeKind::CrackEnergy
        | ProbeKind::Balance
        | ProbeKind::HitEnergy
        | ProbeKind::HitTook => "J",
        _ => "1",
    }
}

/// Reads the probes of a document.
pub(super) fn read(shop: &mut ResolveContext<'_>, probes: &[Probe], scene: &Scene) -> Vec<Watch> {
    let mut watches = Vec::new();
    for (index, probe) in probes.iter().enumerate() {
        let at = item("probe", index);
        let given = [
            ("body", probe.body.is_some()),
            ("other", probe.other.is_some()),
            ("component", probe.component.is_some()),
            ("nth", probe.nth.is_some()),
            ("share", probe.share.is_some()),
        ];
        asked::keys(shop, &given, takes(probe.kind), &at);
        let tensor = probe.kind == ProbeKind::Inertia;
        let mut part = part(probe.component, tensor);
        if part == Ok(TensorPart::Mises) {
            part = Err("moments of inertia have no equivalent of von Mises'");
        }
        watches.push(Watch {
            kind: probe.kind,
            bodies: named(shop, "body", probe.body.as_deref(), scene, &at),
            others: named(shop, "other", probe.other.as_deref(), scene, &at),
            part: part.unwrap_or_else(|why| {
                shop.wrong(&join(&at, "component"), why);
                TensorPart::Size
            }),
            nth: probe.nth.unwrap_or(1).saturating_sub(1) as usize,
            share: probe.share.unwrap_or(0.0),
        });
    }
    watches
}

/// The bodies that are called so, or were made by what is.
fn named(
    shop: &mut ResolveContext<'_>,
    key: &str,
    name: Option<&str>,
    scene: &Scene,
    at: &[Step],
) -> Option<BTreeSet<String>> {
    let name = name?;
    let called = |body: &&SceneBody| body.name == name || body.generator.as_deref() == Some(name);
    let found: BTreeSet<String> =
        scene.bodies.iter().filter(called).map(|body| body.name.clone()).collect();
    if found.is_empty() {
        let of = |body: &SceneBody| body.generator.clone().unwrap_or_else(|| body.name.clone());
        let known: BTreeSet<String> = scene.bodies.iter().map(of).collect();
        let known: Vec<&str> = known.iter().map(String::as_str).collect();
        let message = format!("the scene has no body \"{name}\"");
        shop.wrong_with(&join(at, key), message, suggest(name, &known));
    }
    Some(found)
}
