//! Probes of the whole: names of bodies looked up, keys checked against their kinds.

use super::super::asked;
use super::super::paths::item;
use super::super::watch::part;
use super::format::{SceneProbeConfig, SceneProbeKind};
use cullet_document::error::suggest;
use cullet_document::tree::{Step, join};
use cullet_scene::context::ResolveContext;
use cullet_scene::{Scene, SceneBody};
use cullet_specimen::TensorPart;
use std::collections::BTreeSet;

/// A probe with its names looked up.
#[derive(Clone, Debug, PartialEq)]
pub struct ResolvedProbe {
    /// What it watches.
    pub kind: SceneProbeKind,
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
const fn takes(kind: SceneProbeKind) -> &'static [&'static str] {
    match kind {
        SceneProbeKind::Position
        | SceneProbeKind::Velocity
        | SceneProbeKind::Spin
        | SceneProbeKind::Inertia => &["body*", "component*"],
        SceneProbeKind::Displacement
        | SceneProbeKind::Momentum
        | SceneProbeKind::AngularMomentum => &["body", "component*"],
        SceneProbeKind::Balance => &[],
        SceneProbeKind::Pieces => &["body*", "share"],
        SceneProbeKind::Largest => &["body*"],
        SceneProbeKind::Hits => &["body", "other"],
        SceneProbeKind::HitOrder
        | SceneProbeKind::HitTime
        | SceneProbeKind::HitSpeed
        | SceneProbeKind::HitImpulse
        | SceneProbeKind::HitEnergy
        | SceneProbeKind::HitTook
        | SceneProbeKind::HitMass
        | SceneProbeKind::HitDuration
        | SceneProbeKind::HitRadius
        | SceneProbeKind::HitForce => &["body*", "other", "nth"],
        _ => &["body"],
    }
}

pub(super) const fn unit(kind: SceneProbeKind) -> &'static str {
    match kind {
        SceneProbeKind::Position | SceneProbeKind::Displacement | SceneProbeKind::HitRadius => "m",
        SceneProbeKind::Velocity | SceneProbeKind::HitSpeed => "m/s",
        SceneProbeKind::Spin => "rad/s",
        SceneProbeKind::Mass | SceneProbeKind::HitMass => "kg",
        SceneProbeKind::Volume => "m3",
        SceneProbeKind::Inertia => "kg m2",
        SceneProbeKind::Momentum => "kg m/s",
        SceneProbeKind::AngularMomentum => "kg m2/s",
        SceneProbeKind::HitTime | SceneProbeKind::HitDuration => "s",
        SceneProbeKind::HitImpulse => "N s",
        SceneProbeKind::HitForce => "N",
        SceneProbeKind::Kinetic
        | SceneProbeKind::Potential
        | SceneProbeKind::Energy
        | SceneProbeKind::HitLoss
        | SceneProbeKind::BreakLoss
        | SceneProbeKind::CrackEnergy
        | SceneProbeKind::Balance
        | SceneProbeKind::HitEnergy
        | SceneProbeKind::HitTook => "J",
        _ => "1",
    }
}

/// Reads the probes of a document.
pub(super) fn read(
    shop: &mut ResolveContext<'_>,
    probes: &[SceneProbeConfig],
    scene: &Scene,
) -> Vec<ResolvedProbe> {
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
        let tensor = probe.kind == SceneProbeKind::Inertia;
        let mut part = part(probe.component, tensor);
        if part == Ok(TensorPart::Mises) {
            part = Err("moments of inertia have no equivalent of von Mises'");
        }
        watches.push(ResolvedProbe {
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
