//! Where bodies are: whether their places follow their velocities (F42), and which overlap (F36).

use crate::error::WorldError;
use crate::id::BodyId;
use crate::state::WorldState;

/// Mass ratio up to which the engine carries a body on another \[1\].
const CARRIED: f64 = 200.0;

/// Overlap over the size of the lighter body from which on it has sunk \[1\].
const SUNK: f64 = 0.02;

/// [`crate::World::overlaps`].
pub(crate) fn overlaps(world: &WorldState) -> Vec<(BodyId, BodyId, f64)> {
    let found = world.rigid.overlaps();
    found.into_iter().map(|(a, b, depth)| (BodyId(a), BodyId(b), depth)).collect()
}

/// [`crate::World::sunk`].
pub(crate) fn sunk(world: &WorldState) -> Vec<String> {
    let describe = |(a, b, depth): (BodyId, BodyId, f64)| {
        let (a, b) = (world.bodies.get(&a.0)?, world.bodies.get(&b.0)?);
        let (light, heavy) = if a.mass < b.mass { (a, b) } else { (b, a) };
        let ratio = heavy.mass / light.mass;
        let share = depth / libm::cbrt(light.volume);
        let sunk = !heavy.immovable() && ratio > CARRIED && share > SUNK;
        sunk.then(|| {
            format!(
                "{} and {} overlap by {depth:.3e} m, {share:.2} of its size: the other has \
                 {ratio:.0} times its mass, {CARRIED} are carried (F36)",
                light.name, heavy.name
            )
        })
    };
    overlaps(world).into_iter().filter_map(describe).collect()
}

/// [`crate::World::pressed`].
pub(crate) fn pressed(world: &WorldState) -> Option<Pressed<'_>> {
    let driven = world.bodies.iter().filter(|(_, body)| body.driven.is_some());
    driven
        .flat_map(|(&press, by)| {
            let found = world.rigid.depths(press).into_iter();
            found.filter_map(move |(id, depth)| {
                let body = world.bodies.get(&id)?;
                let share = depth / libm::cbrt(body.volume);
                (share > SUNK).then_some(Pressed { body: &body.name, by: &by.name, depth, share })
            })
        })
        .next()
}

/// A body that something driven has gone into.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Pressed<'a> {
    /// Its name.
    pub body: &'a str,
    /// What is driven.
    pub by: &'a str,
    /// How deep \[m\].
    pub depth: f64,
    /// That over its size, the cube root of its volume \[1\].
    pub share: f64,
}

/// Whether bodies go where their velocities take them (F42).
pub(crate) fn check_places(world: &mut WorldState) -> Result<(), WorldError> {
    let (bodies, step) = (&world.bodies, world.settings.step);
    world.frozen.keep(|id| bodies.contains_key(&id));
    for (&id, body) in bodies.iter().filter(|(_, body)| !body.immovable()) {
        let (Some(before), Some(after)) = (world.rigid.before(id), world.rigid.motion(id)) else {
            continue;
        };
        if let Some((moved, due)) = world.frozen.look(id, before, &after, step) {
            return Err(WorldError::Frozen {
                name: body.name.clone(),
                step: world.steps,
                velocity: after.velocity,
                moved,
                due,
            });
        }
    }
    Ok(())
}
