//! Where bodies are: whether their places follow their velocities (F42), and which overlap (F36).

use crate::error::WorldError;
use crate::id::BodyId;
use crate::world::World;

/// Mass ratio up to which the engine carries a body on another \[1\].
const CARRIED: f64 = 200.0;

/// Overlap over the size of the lighter body from which on it has sunk \[1\].
const SUNK: f64 = 0.02;

impl World {
    /// Pairs of bodies that overlap where they are, with an estimate of the depth \[m\]; at least
    /// one of each can move.
    #[must_use]
    pub fn overlaps(&self) -> Vec<(BodyId, BodyId, f64)> {
        let found = self.rigid.overlaps();
        found.into_iter().map(|(a, b, depth)| (BodyId(a), BodyId(b), depth)).collect()
    }

    /// Bodies that lie sunk into others more than 200 times as heavy, deeper than a fiftieth of
    /// their own size: the engine does not carry such weights (F36). A sentence each.
    #[must_use]
    pub fn sunk(&self) -> Vec<String> {
        let told = |(a, b, depth): (BodyId, BodyId, f64)| {
            let (a, b) = (self.bodies.get(&a.0)?, self.bodies.get(&b.0)?);
            let (light, heavy) = if a.mass < b.mass { (a, b) } else { (b, a) };
            let ratio = heavy.mass / light.mass;
            let share = depth / libm::cbrt(light.volume);
            let sunk = !heavy.fixed && ratio > CARRIED && share > SUNK;
            sunk.then(|| {
                format!(
                    "{} and {} overlap by {depth:.3e} m, {share:.2} of its size: the other has \
                     {ratio:.0} times its mass, {CARRIED} are carried (F36)",
                    light.name, heavy.name
                )
            })
        };
        self.overlaps().into_iter().filter_map(told).collect()
    }

    /// Whether bodies go where their velocities take them (F42).
    pub(crate) fn check_places(&mut self) -> Result<(), WorldError> {
        let (bodies, step) = (&self.bodies, self.settings.step);
        self.frozen.keep(|id| bodies.contains_key(&id));
        for (&id, body) in bodies.iter().filter(|(_, body)| !body.fixed) {
            let (Some(before), Some(after)) = (self.rigid.before(id), self.rigid.motion(id)) else {
                continue;
            };
            if let Some((moved, due)) = self.frozen.look(id, before, &after, step) {
                return Err(WorldError::Frozen {
                    name: body.name.clone(),
                    step: self.steps,
                    velocity: after.velocity,
                    moved,
                    due,
                });
            }
        }
        Ok(())
    }
}
