//! Hits that the scene gives settings of their own: which hit an entry is about, and how that is
//! solved.

use super::job::DirectedHit;
use super::{RunError, SceneRun};
use cullet_record::Level;
use cullet_world::BodyId;

impl SceneRun<'_> {
    /// What the scene says of the hit that a body has in this step, unless another one was meant.
    pub(super) fn directed_hit(&self, body: BodyId) -> Option<Box<DirectedHit>> {
        let hits = &self.scene.directions.hits;
        if hits.is_empty() {
            return None;
        }
        let name = self.world.body(body)?.name;
        let now = self.world.time() + 0.5 * self.scene.world.step;
        let of_body = hits.iter().enumerate().filter(|(_, hit)| hit.body == name && hit.at <= now);
        let of_body = of_body.filter(|(index, _)| !self.directed.contains_key(index));
        // The entry of the latest time, where several wait for this body.
        let (index, hit) = of_body.max_by(|(_, a), (_, b)| a.at.total_cmp(&b.at))?;
        let choice = self.origins.get(&body)?.choice.of_hit(hit, body);
        let seed = hit.seed.unwrap_or(self.scene.world.seed);
        Some(Box::new(DirectedHit { index, choice, seed, opened: false }))
    }

    /// The hit is solved, so that its entry is about no later one; neither are those that an entry
    /// of a later time went before.
    pub(super) fn take_directed(&mut self, hit: Option<&DirectedHit>) {
        let Some(taken) = hit.map(|hit| hit.index) else { return };
        let hits = &self.scene.directions.hits;
        let Some(own) = hits.get(taken) else { return };
        for (index, other) in hits.iter().enumerate() {
            if other.body == own.body && other.at <= own.at {
                self.directed.entry(index).or_insert(taken);
            }
        }
    }

    /// A job of the hit came to something.
    pub(super) fn note_directed(&mut self, hit: Option<&DirectedHit>) {
        self.effective.extend(hit.map(|hit| hit.index));
    }

    /// Why a job is solved as it is, in words, for the first job of a hit.
    pub(super) fn directed_reason(&self, hit: Option<&mut Box<DirectedHit>>) -> Option<String> {
        let hit = hit.filter(|hit| !hit.opened)?;
        hit.opened = true;
        Some(format!("directed: {}", self.scene.directions.hits[hit.index]))
    }

    /// Warns of entries that were about no hit.
    pub(super) fn tell_undirected(&mut self) -> Result<(), RunError> {
        for (index, hit) in self.scene.directions.hits.iter().enumerate() {
            let (body, at) = (&hit.body, hit.at);
            let why = match self.directed.get(&index) {
                None => format!("no hit of `{body}` from {at} s on was solved"),
                Some(&taken) if taken != index => {
                    format!("hit[{taken}] is about the same hit of `{body}`, from a later time on")
                }
                Some(_) if !self.effective.contains(&index) => {
                    format!("no solve of that hit of `{body}` came to an end")
                }
                Some(_) => continue,
            };
            let line = format!("warning: hit[{index}] had no effect: {why}");
            self.recorder.log(Level::Warning, line.clone())?;
            self.say(line);
        }
        Ok(())
    }
}
