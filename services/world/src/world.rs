//! The world: bodies in, steps, hits out. What each operation does is in its own file.

use crate::body::{Body, BodySpec, BodyView};
use crate::cluster::{Part, sum};
use crate::debris::DebrisParticle;
use crate::error::{ReplaceError, WorldError};
use crate::exchange::Exchange;
use crate::id::BodyId;
use crate::impact::Hit;
use crate::ledger::Totals;
use crate::measure::BodyMeasure;
use crate::motion::Motion;
use crate::places::{Pressed, overlaps, pressed, sunk};
use crate::replace::{Breakage, Replacement, break_up};
use crate::reshape::{Reshape, reshape};
use crate::rigid::{BadPart, Fit, Shape};
use crate::settings::WorldSettings;
use crate::soft::{BodyForWindow, body_for_window, lead, push};
use crate::state::WorldState;
use crate::step::step;
use crate::support::{HeldContact, find_supports};
use cullet_geometry::{Pose, Vec3};
use cullet_model::Fragment;

/// Rigid bodies, their contacts, and the books.
pub struct World {
    state: WorldState,
}

impl World {
    /// An empty world.
    ///
    /// # Errors
    /// A setting outside its range.
    pub fn new(settings: WorldSettings) -> Result<Self, WorldError> {
        settings.check()?;
        Ok(Self { state: WorldState::new(settings) })
    }

    /// Puts a body in.
    ///
    /// # Errors
    /// What is wrong with it, with value and bound; or the budget of bodies is spent.
    pub fn insert(&mut self, spec: BodySpec) -> Result<BodyId, WorldError> {
        let count = self.state.bodies.len() + 1;
        if count > self.state.settings.max_bodies {
            return Err(WorldError::TooManyBodies { count, limit: self.state.settings.max_bodies });
        }
        let (body, shape) = self.made(&spec)?;
        let motion = self.first_motion(&spec);
        let id = self.state.take_id();
        self.state.rigid.insert(id, &body, shape, &motion, 0.0);
        let speed = motion.velocity.norm() + motion.spin.norm() * body.reach;
        if !body.immovable() && speed <= self.state.settings.resting_speed {
            self.state.settling.put(id, motion);
        }
        self.state.bodies.insert(id, body);
        Ok(BodyId(id))
    }

    /// Whether [`World::insert`] takes a body while there is room: for who wants to know before.
    ///
    /// # Errors
    /// What is wrong with it, with value and bound.
    pub fn admits(&self, spec: &BodySpec) -> Result<(), WorldError> {
        self.made(spec).map(|_| ())
    }

    fn first_motion(&self, spec: &BodySpec) -> Motion {
        let still = Vec3::zeros();
        let (velocity, spin) = if spec.fixed { (still, still) } else { (spec.velocity, spec.spin) };
        let Some(path) = &spec.driven else {
            return Motion { pose: spec.pose, velocity, spin };
        };
        let (velocity, spin) = path.velocity(self.time(), self.state.settings.step);
        Motion { pose: path.at(self.time()), velocity, spin }
    }

    fn made(&self, spec: &BodySpec) -> Result<(Body, Shape), WorldError> {
        let settings = &self.state.settings;
        let body = Body::new(spec, &settings.tiers, settings.max_generation, f64::NEG_INFINITY)?;
        let bad_part = |BadPart { index, why }| WorldError::Hull {
            name: spec.name.clone(),
            index,
            count: spec.hulls.len(),
            why,
        };
        let shape = Shape::new(&body, &spec.hulls, Fit::Body).map_err(bad_part)?;
        Ok((body, shape))
    }

    /// Simulated time \[s\].
    #[must_use]
    pub fn time(&self) -> f64 {
        self.state.time()
    }

    /// Steps taken.
    #[must_use]
    pub fn step_count(&self) -> u64 {
        self.state.steps
    }

    /// The settings.
    #[must_use]
    pub fn settings(&self) -> &WorldSettings {
        &self.state.settings
    }

    /// How many bodies there are.
    #[must_use]
    pub fn len(&self) -> usize {
        self.state.bodies.len()
    }

    /// Is the world empty?
    #[must_use]
    pub fn is_empty(&self) -> bool {
        self.state.bodies.is_empty()
    }

    /// All bodies in id order.
    pub fn bodies(&self) -> impl Iterator<Item = BodyView<'_>> {
        self.state.bodies.iter().filter_map(|(&id, body)| self.view(id, body))
    }

    /// One body, if it is (still) there.
    #[must_use]
    pub fn body(&self, id: BodyId) -> Option<BodyView<'_>> {
        self.state.bodies.get(&id.0).and_then(|body| self.view(id.0, body))
    }

    /// The sizes of a body, worked out once; `None` when it is gone.
    #[must_use]
    pub fn measure(&self, id: BodyId) -> Option<&BodyMeasure> {
        self.state.bodies.get(&id.0).map(Body::measure)
    }

    fn view<'a>(&'a self, id: u32, body: &'a Body) -> Option<BodyView<'a>> {
        let motion = self.state.rigid.motion(id)?;
        Some(BodyView {
            id: BodyId(id),
            name: &body.name,
            solid: &body.solid,
            material: &body.material,
            pose: motion.pose,
            velocity: motion.velocity,
            spin: motion.spin,
            mass: body.mass,
            density: body.density,
            volume: body.volume,
            volume_ratio: body.volume / body.original_volume,
            weakest: body.weakest,
            tier: body.tier,
            fixed: body.fixed,
            driven: body.driven.is_some(),
            breakable: body.breakable,
            sleeping: self.state.rigid.sleeping(id),
            parent: body.parent,
            generation: body.generation,
        })
    }

    /// Are all moving bodies asleep, and all paths of driven ones at their end?
    #[must_use]
    pub fn at_rest(&self) -> bool {
        self.state.bodies.iter().all(|(&id, body)| match &body.driven {
            Some(path) => path.end() <= self.time(),
            None => body.fixed || self.state.rigid.sleeping(id),
        })
    }

    /// The sums that physics keeps: bodies that move, and debris.
    #[must_use]
    pub fn totals(&self) -> Totals {
        let moving = self.state.bodies.iter().filter(|(_, body)| !body.immovable());
        let bodies =
            moving.filter_map(|(&id, body)| Some(Part::new(body, &self.state.rigid.motion(id)?)));
        let parts: Vec<Part> =
            bodies.chain(self.state.debris.grains.iter().map(DebrisParticle::part)).collect();
        let total = sum(parts.iter());
        let weigh = |p: &Part| -p.mass * self.state.settings.gravity.dot(&p.centre);
        Totals {
            mass: parts.iter().map(|p| p.mass).sum(),
            momentum: total.linear,
            angular_momentum: total.angular,
            kinetic_energy: total.kinetic,
            potential_energy: parts.iter().map(weigh).sum(),
            given_to_fixed: self.state.replaced.sink.linear,
            angular_given_to_fixed: self.state.replaced.sink.angular,
            driven_work: self.state.flows.driven_work,
            field_work: self.state.flows.field_work,
            field_impulse: self.state.flows.field_impulse,
            removed_mass: self.state.flows.removed_mass,
            removed_momentum: self.state.flows.removed_momentum,
            removed_energy: self.state.flows.removed_energy,
            slept_momentum: self.state.flows.slept_momentum,
            slept_energy: self.state.flows.slept_energy,
        }
    }

    /// Feeds all that decides the run to `feed`, in id order, bit for bit: the step, then for each
    /// body its id, position, orientation, velocity and spin, and for each grain of debris its id,
    /// position and velocity.
    pub fn digest(&self, feed: &mut dyn FnMut(&[u8])) {
        feed(&self.state.steps.to_le_bytes());
        for &id in self.state.bodies.keys() {
            feed(&id.to_le_bytes());
            let Some(m) = self.state.rigid.motion(id) else {
                continue;
            };
            let (x, q) = (m.centre(), m.pose.rotation.coords);
            for value in x.iter().chain(q.iter()).chain(m.velocity.iter()).chain(m.spin.iter()) {
                feed(&value.to_bits().to_le_bytes());
            }
        }
        for grain in &self.state.debris.grains {
            feed(&grain.id.to_le_bytes());
            for value in grain.position.iter().chain(grain.velocity.iter()) {
                feed(&value.to_bits().to_le_bytes());
            }
        }
    }

    /// All grains of debris, oldest first.
    #[must_use]
    pub fn grains(&self) -> &[DebrisParticle] {
        &self.state.debris.grains
    }

    /// One step. Returns the hits whose contact episode ended in it, in the order of the bodies
    /// hit.
    ///
    /// # Errors
    /// A motion that is not finite, a body whose place does not follow its velocity, or a panic of
    /// the engine; the world must not be used after any of them.
    pub fn step(&mut self) -> Result<Vec<Hit>, WorldError> {
        step(&mut self.state)
    }

    /// How many blows broke what a body comes from, before these hits. A striker that goes on
    /// through what it broke hits the pieces in the same blow.
    #[must_use]
    pub fn blows_before(&self, body: BodyId, hits: &[Hit]) -> Option<u32> {
        let body = self.state.bodies.get(&body.0)?;
        Some(body.blows_before(hits.iter().map(|hit| (hit.other.0, hit.time))))
    }

    /// What a body rested on when these hits, of the step just taken, struck it: bodies that it
    /// touched more slowly than a hit, each as discs that cover where they touch. Joints are none.
    #[must_use]
    pub fn supports(&self, body: BodyId, hits: &[Hit]) -> Vec<HeldContact> {
        find_supports(&self.state, body, hits)
    }

    /// [`World::break_up`] into pieces only.
    ///
    /// # Errors
    /// See [`ReplaceError`].
    pub fn replace(
        &mut self,
        body: BodyId,
        hits: &[Hit],
        pieces: Vec<Fragment>,
        fracture_energy: f64,
    ) -> Result<Replacement, ReplaceError> {
        let breakage = Breakage { pieces, fracture_energy, ..Breakage::default() };
        self.break_up(body, hits, breakage)
    }

    /// Replaces a body by its pieces.
    ///
    /// The hits are those that broke it, as one [`World::step`] returned them (the fragments may be
    /// late). With none, the pieces keep the body's motion and only move apart. On any error
    /// nothing has changed.
    ///
    /// # Errors
    /// See [`ReplaceError`].
    pub fn break_up(
        &mut self,
        body: BodyId,
        hits: &[Hit],
        breakage: Breakage,
    ) -> Result<Replacement, ReplaceError> {
        break_up(&mut self.state, body, hits, breakage)
    }

    /// Gives a body a new shape: its id, name, tier and generation stay. Its mass is the old one,
    /// spread evenly over the new volume, and its centre of mass stays where it is: a deformation
    /// moves no mass on the whole. On any error nothing has changed.
    ///
    /// The hits are as in [`World::break_up`]. A body that never moves stays where its shape was
    /// given; what contacts took out of the motion then has to pay the work.
    ///
    /// # Errors
    /// See [`ReplaceError`].
    pub fn reshape(
        &mut self,
        id: BodyId,
        hits: &[Hit],
        new: Reshape,
    ) -> Result<Replacement, ReplaceError> {
        reshape(&mut self.state, id, hits, new)
    }

    /// A body as a window of something that moves as it deforms needs it; `None` when it is gone.
    #[must_use]
    pub fn body_for_window(&self, id: BodyId) -> Option<BodyForWindow> {
        body_for_window(&self.state, id)
    }

    /// Gives a body an impulse and its moment about the body's centre, before the step in which it
    /// acts. Whether the body is there and can move.
    pub fn push(&mut self, id: BodyId, given: &Exchange) -> bool {
        push(&mut self.state, id, given)
    }

    /// Puts a body where a window has it after the step just taken, with the velocity and the
    /// angular momentum that it has. Not so a body that touches another of the rigid world in that
    /// step, or that a joint holds. Whether it was put there.
    pub fn lead(&mut self, id: BodyId, pose: &Pose) -> bool {
        lead(&mut self.state, id, pose)
    }

    /// Pairs of bodies that overlap where they are, with an estimate of the depth \[m\]; at least
    /// one of each can move.
    #[must_use]
    pub fn overlaps(&self) -> Vec<(BodyId, BodyId, f64)> {
        overlaps(&self.state)
    }

    /// A body into which something driven has gone deeper than a fiftieth of its size, by the
    /// contacts of the last step.
    #[must_use]
    pub fn pressed(&self) -> Option<Pressed<'_>> {
        pressed(&self.state)
    }

    /// Bodies that lie sunk into others more than 200 times as heavy, deeper than a fiftieth of
    /// their own size: the engine does not carry such weights (F36). A sentence each.
    #[must_use]
    pub fn sunk(&self) -> Vec<String> {
        sunk(&self.state)
    }
}

mod joined;

#[cfg(test)]
mod tests;
