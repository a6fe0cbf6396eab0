//! Places follow velocities, or the run ends (F42).

use crate::error::WorldError;
use crate::world::World;

impl World {
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
