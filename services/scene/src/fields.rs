//! Fields that act on bodies from afar: wind, attractors, turbulence, planes that remove.

use super::body::{MAX_DISTANCE, MAX_SPEED};
use super::body_names::BodyNames;
use super::context::ResolveContext;
use super::direction::direction;
use super::directions::{FieldLaw, SceneField};
use super::format::{FieldEntry, FieldForm};
use super::scene::SceneBody;
use cullet_document::check::tell;
use cullet_document::tree::{Path, join};
use cullet_geometry::Vec3;
use std::collections::BTreeSet;

/// Drag coefficient of a ball in turbulent air  [Hoerner 1965, ch. III].
const BALL_DRAG: f64 = 0.47;
/// Air at 20 °C and 101325 Pa \[kg/m³\].
const AIR_DENSITY: f64 = 1.2;
/// Pull of an attractor beyond its size, as that of gravity.
const FALLOFF: u32 = 2;
/// Of an attractor or of eddies \[m\].
const SIZE: f64 = 1.0;

/// The key of each kind of field, which kinds take it, and which of those need it.
const KEYS: [(&str, &[FieldForm], &[FieldForm]); 9] = {
    use FieldForm::{Attractor, Kill, Turbulence, Wind};
    [
        ("velocity", &[Wind], &[Wind]),
        ("drag", &[Wind], &[]),
        ("density", &[Wind], &[]),
        ("point", &[Attractor, Kill], &[Attractor, Kill]),
        ("strength", &[Attractor, Turbulence], &[Attractor, Turbulence]),
        ("falloff", &[Attractor], &[]),
        ("size", &[Attractor, Turbulence], &[]),
        ("rate", &[Turbulence], &[]),
        ("normal", &[Kill], &[Kill]),
    ]
};

/// A field as it is written; `seed`: of the world. What is wrong with it is noted.
pub(super) fn field(
    context: &mut ResolveContext<'_>,
    bodies: &[SceneBody],
    names: &BodyNames<'_>,
    (written, seed): (&FieldEntry, u64),
    path: &Path,
) -> Option<SceneField> {
    let before = context.errors.len();
    let kind = written.kind;
    let seeded = [("seed", &[FieldForm::Turbulence][..], &[][..])];
    for (key, takes, needs) in KEYS.into_iter().chain(seeded) {
        let there = context.root.has(&join(path, key));
        if there && !takes.contains(&kind) {
            context.wrong(&join(path, key), format!("is not for {}", word(kind)));
        } else if !there && needs.contains(&kind) && context.lacks(path, &[key]) {
            context.wrong(path, format!("`{key}` is missing: {} needs it", word(kind)));
        }
    }
    let named = names.all(context, &written.bodies, &join(path, "bodies"));
    let some = !written.bodies.is_empty();
    let only: BTreeSet<String> = named.iter().map(|&body| bodies[body].name.clone()).collect();
    let limits = [
        ("velocity", written.velocity, MAX_SPEED, "m/s"),
        ("point", written.point, MAX_DISTANCE, "m"),
    ];
    for (key, value, most, unit) in limits {
        let size = value.map_or(0.0, |value| Vec3::from(value).norm());
        if size > most || !size.is_finite() {
            let (most, size) = (tell(most), tell(size));
            let message = format!("must be at most {most} {unit} long; it is {size} {unit}");
            context.wrong(&join(path, key), message);
        }
    }
    let normal = match written.normal.map(direction) {
        Some(Err(why)) => {
            context.wrong(&join(path, "normal"), why);
            None
        }
        Some(Ok(normal)) => Some(Vec3::from(normal)),
        None => None,
    };
    let strength = written.strength.unwrap_or_default();
    let (size, point) = (written.size.unwrap_or(SIZE), written.point.unwrap_or_default().into());
    let law = match kind {
        FieldForm::Wind => FieldLaw::Wind {
            velocity: written.velocity.unwrap_or_default().into(),
            drag: written.drag.unwrap_or(BALL_DRAG),
            density: written.density.unwrap_or(AIR_DENSITY),
        },
        FieldForm::Attractor => {
            let falloff = written.falloff.unwrap_or(FALLOFF);
            FieldLaw::Attractor { point, strength, falloff, size }
        }
        FieldForm::Turbulence => {
            let (rate, seed) = (written.rate.unwrap_or(0.0), written.seed.unwrap_or(seed));
            FieldLaw::Turbulence { strength, size, rate, seed }
        }
        FieldForm::Kill => FieldLaw::Kill { point, normal: normal.unwrap_or_else(Vec3::z) },
    };
    let made = SceneField { law, bodies: some.then_some(only) };
    (context.errors.len() == before).then_some(made)
}

/// What a kind of field is called.
const fn word(kind: FieldForm) -> &'static str {
    match kind {
        FieldForm::Wind => "wind",
        FieldForm::Attractor => "an attractor",
        FieldForm::Turbulence => "turbulence",
        FieldForm::Kill => "`kill`",
    }
}
