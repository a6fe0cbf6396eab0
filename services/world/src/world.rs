//! The world: bodies in, steps, hits out.

use crate::body::{Body, BodySpec, BodyView};
use crate::cluster::{Part, sum};
use crate::debris::DebrisParticle;
use crate::episode::{Episode, Episodes};
use crate::error::WorldError;
use crate::exchange::{PendingExchange, Received, Stepped, received, rest, sums};
use crate::frozen::Frozen;
use crate::id::BodyId;
use crate::impact::{EpisodeOutcome, Hit, Party, effective_mass, hits};
use crate::ledger::{Sink, Totals};
use crate::measure::BodyMeasure;
use crate::motion::Motion;
use crate::resting::Resting;
use crate::rigid::{BadPart, Contact, Fit, Rigid, Shape};
use crate::settings::WorldSettings;
use crate::settling::Settling;
use cullet_geometry::Vec3;
use std::collections::BTreeMap;

/// Rigid bodies, their contacts, and the books.
pub struct World {
    pub(crate) settings: WorldSettings,
    pub(crate) rigid: Rigid,
    pub(crate) bodies: BTreeMap<u32, Body>,
    /// What became of bodies that broke.
    pub(crate) children: BTreeMap<u32, Vec<u32>>,
    /// What a replacement already settled for the other body of an episode.
    pub(crate) debts: BTreeMap<(u64, u32), PendingExchange>,
    pub(crate) sink: Sink,
    pub(crate) episodes: Episodes,
    /// What the pairs that rest did lately.
    pub(crate) resting: Resting,
    /// Bodies that nothing has struck yet.
    pub(crate) settling: Settling,
    /// Debris.
    pub(crate) grains: Vec<DebrisParticle>,
    pub(crate) next_id: u32,
    pub(crate) frozen: Frozen,
    pub(crate) steps: u64,
}

impl World {
    /// An empty world.
    ///
    /// # Errors
    /// A setting outside its range.
    pub fn new(settings: WorldSettings) -> Result<Self, WorldError> {
        settings.check()?;
        Ok(Self {
            rigid: Rigid::new(&settings),
            settings,
            bodies: BTreeMap::new(),
            children: BTreeMap::new(),
            debts: BTreeMap::new(),
            sink: Sink::default(),
            episodes: Episodes::default(),
            resting: Resting::default(),
            settling: Settling::default(),
            grains: Vec::new(),
            next_id: 0,
            frozen: Frozen::default(),
            steps: 0,
        })
    }

    /// Puts a body in.
    ///
    /// # Errors
    /// What is wrong with it, with value and bound; or the budget of bodies is spent.
    pub fn insert(&mut self, spec: BodySpec) -> Result<BodyId, WorldError> {
        let count = self.bodies.len() + 1;
        if count > self.settings.max_bodies {
            return Err(WorldError::TooManyBodies { count, limit: self.settings.max_bodies });
        }
        let (body, shape) = self.made(&spec)?;
        let still = Vec3::zeros();
        let (velocity, spin) = if spec.fixed { (still, still) } else { (spec.velocity, spec.spin) };
        let motion = Motion { pose: spec.pose, velocity, spin };
        let id = self.next_id;
        self.next_id += 1;
        self.rigid.insert(id, &body, shape, &motion, 0.0);
        let speed = motion.velocity.norm() + motion.spin.norm() * body.reach;
        if !body.fixed && speed <= self.settings.resting_speed {
            self.settling.put(id, motion);
        }
        self.bodies.insert(id, body);
        Ok(BodyId(id))
    }

    /// Whether [`World::insert`] takes a body while there is room: for who wants to know before.
    ///
    /// # Errors
    /// What is wrong with it, with value and bound.
    pub fn admits(&self, spec: &BodySpec) -> Result<(), WorldError> {
        self.made(spec).map(|_| ())
    }

    fn made(&self, spec: &BodySpec) -> Result<(Body, Shape), WorldError> {
        let settings = &self.settings;
        let body = Body::new(spec, &settings.tiers, settings.max_generation, f64::NEG_INFINITY)?;
        let told = |BadPart { index, why }| WorldError::Hull {
            name: spec.name.clone(),
            index,
            count: spec.hulls.len(),
            why,
        };
        let shape = Shape::new(&body, &spec.hulls, Fit::Body).map_err(told)?;
        Ok((body, shape))
    }

    /// Simulated time \[s\].
    #[must_use]
    pub fn time(&self) -> f64 {
        self.steps as f64 * self.settings.step
    }

    /// Steps taken.
    #[must_use]
    pub fn step_count(&self) -> u64 {
        self.steps
    }

    /// The settings.
    #[must_use]
    pub fn settings(&self) -> &WorldSettings {
        &self.settings
    }

    /// How many bodies there are.
    #[must_use]
    pub fn len(&self) -> usize {
        self.bodies.len()
    }

    /// Is the world empty?
    #[must_use]
    pub fn is_empty(&self) -> bool {
        self.bodies.is_empty()
    }

    /// All bodies in id order.
    pub fn bodies(&self) -> impl Iterator<Item = BodyView<'_>> {
        self.bodies.iter().filter_map(|(&id, body)| self.view(id, body))
    }

    /// One body, if it is (still) there.
    #[must_use]
    pub fn body(&self, id: BodyId) -> Option<BodyView<'_>> {
        self.bodies.get(&id.0).and_then(|body| self.view(id.0, body))
    }

    /// The sizes of a body, worked out once; `None` when it is gone.
    #[must_use]
    pub fn measure(&self, id: BodyId) -> Option<&BodyMeasure> {
        self.bodies.get(&id.0).map(Body::measure)
    }

    fn view<'a>(&'a self, id: u32, body: &'a Body) -> Option<BodyView<'a>> {
        let motion = self.rigid.motion(id)?;
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
            breakable: body.breakable,
            sleeping: self.rigid.sleeping(id),
            parent: body.parent,
            generation: body.generation,
        })
    }

    /// Are all moving bodies asleep?
    #[must_use]
    pub fn at_rest(&self) -> bool {
        self.bodies.iter().all(|(&id, body)| body.fixed || self.rigid.sleeping(id))
    }

    /// The sums that physics keeps: bodies that move, and debris.
    #[must_use]
    pub fn totals(&self) -> Totals {
        let moving = self.bodies.iter().filter(|(_, body)| !body.fixed);
        let bodies =
            moving.filter_map(|(&id, body)| Some(Part::new(body, &self.rigid.motion(id)?)));
        let parts: Vec<Part> = bodies.chain(self.grains.iter().map(DebrisParticle::part)).collect();
        let total = sum(parts.iter());
        let weigh = |p: &Part| -p.mass * self.settings.gravity.dot(&p.centre);
        Totals {
            mass: parts.iter().map(|p| p.mass).sum(),
            momentum: total.linear,
            angular_momentum: total.angular,
            kinetic_energy: total.kinetic,
            potential_energy: parts.iter().map(weigh).sum(),
            given_to_fixed: self.sink.linear,
            angular_given_to_fixed: self.sink.angular,
        }
    }

    /// Feeds all that decides the run to `feed`, in id order, bit for bit: the step, then for each
    /// body its id, position, orientation, velocity and spin, and for each grain of debris its id,
    /// position and velocity.
    pub fn digest(&self, feed: &mut dyn FnMut(&[u8])) {
        feed(&self.steps.to_le_bytes());
        for &id in self.bodies.keys() {
            feed(&id.to_le_bytes());
            let Some(m) = self.rigid.motion(id) else {
                continue;
            };
            let (x, q) = (m.centre(), m.pose.rotation.coords);
            for value in x.iter().chain(q.iter()).chain(m.velocity.iter()).chain(m.spin.iter()) {
                feed(&value.to_bits().to_le_bytes());
            }
        }
        for grain in &self.grains {
            feed(&grain.id.to_le_bytes());
            for value in grain.position.iter().chain(grain.velocity.iter()) {
                feed(&value.to_bits().to_le_bytes());
            }
        }
    }

    /// One step. Returns the hits whose contact episode ended in it, in the order of the bodies
    /// hit.
    ///
    /// # Errors
    /// A motion that is not finite, a body whose place does not follow its velocity, or a panic of
    /// the engine; the world must not be used after any of them.
    pub fn step(&mut self) -> Result<Vec<Hit>, WorldError> {
        let start = self.time();
        self.steps += 1;
        self.rigid.step().map_err(|_| WorldError::Engine { step: self.steps })?;
        self.check_finite()?;
        self.check_places()?;
        self.fly();
        let contacts = self.rigid.contacts();
        self.follow(&contacts, start);
        self.see_who_settles();
        let settings = &self.settings;
        let over = self.episodes.take_over(self.time(), settings.resting_speed, settings.episode);
        let judged = over.iter().flat_map(|(pair, episode)| self.judge(*pair, episode));
        let mut hits: Vec<Hit> = judged.collect();
        hits.sort_by_key(|hit| (hit.body, hit.episode));
        Ok(hits)
    }

    fn check_finite(&self) -> Result<(), WorldError> {
        let lost = self.rigid.quarantined().or_else(|| {
            let finite = |id: u32| self.rigid.motion(id).is_none_or(|m| m.finite());
            self.bodies.keys().copied().find(|&id| !finite(id))
        });
        let name =
            |id: u32| self.bodies.get(&id).map_or_else(String::new, |body| body.name.clone());
        match lost {
            Some(id) => Err(WorldError::NotFinite { name: name(id), step: self.steps }),
            None => Ok(()),
        }
    }

    /// Opens episodes and takes in one step of those that are open.
    fn follow(&mut self, contacts: &[Contact], start: f64) {
        self.episodes.begin_step();
        let longest = (self.settings.episode / self.settings.step).ceil() as u64 + 2;
        self.resting.forget(self.steps.saturating_sub(longest));
        let received = self.received(contacts);
        let (dt, gravity) = (self.settings.step, self.settings.gravity);
        for (contact, received) in contacts.iter().zip(&received) {
            let pair = (contact.a, contact.b);
            let (Some(a), Some(b)) = (self.bodies.get(&pair.0), self.bodies.get(&pair.1)) else {
                continue;
            };
            let before = [self.rigid.before(pair.0).copied(), self.rigid.before(pair.1).copied()];
            let [Some(before_a), Some(before_b)] = before else {
                continue;
            };
            let Some(n) = contact.on_b.try_normalize(0.0) else {
                continue;
            };
            let fall = |body: &Body| if body.fixed { 0.0 } else { gravity.dot(&n) };
            let closing_gain = (fall(a) - fall(b)).max(0.0) * dt;
            let speed = contact.closing_speed();
            let fresh = !self.episodes.open.contains_key(&pair);
            self.settling.touch(pair.0, &before_a);
            self.settling.touch(pair.1, &before_b);
            if fresh {
                let young = a.birth.max(b.birth) + self.settings.birth_grace > start;
                let pause = self.settings.episode;
                let least = self.settings.resting_speed;
                if speed <= self.settling.least(pair, [a.fixed, b.fixed], least) {
                    self.resting.add(contact, self.steps, *received);
                    continue;
                }
                if young || !self.episodes.ready(pair, start, pause, speed) {
                    continue;
                }
                // Gravity works until they touch: for the time that the gap takes in this step, and
                // in the last one for as long as they moved.
                let late = |id: u32, body: &Body| fall(body) * dt * (1.0 - self.rigid.moved(id));
                let early = (contact.gap() / (speed * dt)).min(1.0);
                let touch = speed + early * closing_gain - late(pair.0, a) + late(pair.1, b);
                self.episodes.open(contact, start, [before_a, before_b], touch);
                self.settling.end(pair.0);
                self.settling.end(pair.1);
            }
            let point = contact.moment / contact.impulse;
            let mass = effective_mass((a, &before_a), (b, &before_b), &point, &n);
            let weight = mass * closing_gain * if fresh { 0.5 } else { 1.0 };
            if let Some(episode) = self.episodes.open.get_mut(&pair) {
                episode.add(contact, weight, received);
            }
        }
    }

    fn see_who_settles(&mut self) {
        let (now, resting) = (self.time(), self.settings.resting_speed);
        let (rigid, bodies) = (&self.rigid, &self.bodies);
        let motion = |id: u32| Some((rigid.motion(id)?, bodies.get(&id)?.reach));
        self.settling.look(now, resting, motion);
    }

    /// What both bodies of each pair received from their contact over the last step.
    fn received(&self, contacts: &[Contact]) -> Vec<[Received; 2]> {
        let moving = |(id, normals)| {
            let body = self.bodies.get(&id).filter(|body| !body.fixed)?;
            let (&before, after) = (self.rigid.before(id)?, self.rigid.motion(id)?);
            let stepped = Stepped {
                mass: body.mass,
                inertia: body.world_inertia(&before.pose),
                inertia_after: body.world_inertia(&after.pose),
                before,
                after,
            };
            Some((id, rest(&stepped, &self.settings.gravity, self.settings.step, &normals)))
        };
        received(contacts, sums(contacts).into_iter().filter_map(moving).collect())
    }

    /// The hits of a finished episode: none, or one a body that may break and whose threshold it
    /// reached.
    fn judge(&self, (a, b): (u32, u32), episode: &Episode) -> Vec<Hit> {
        let (Some(one), Some(two)) = (self.bodies.get(&b), self.bodies.get(&a)) else {
            return Vec::new();
        };
        let impulse = episode.net_impulse();
        let over = |body: &Body| {
            body.breakable
                && impulse > 0.0
                && impulse >= body.threshold.unwrap_or(self.settings.impulse_threshold)
        };
        let Some(normal) = episode.normal().filter(|_| over(one) || over(two)) else {
            return Vec::new();
        };
        let outcome = EpisodeOutcome {
            episode: episode.number,
            time: episode.opened,
            point: episode.point(),
            normal,
            impulse,
            closing_speed: episode.closing_speed,
            step: self.steps,
            dissipated: episode.dissipated.max(0.0),
        };
        let party = |id: u32, body, side: usize| Party {
            id: BodyId(id),
            body,
            motion: &episode.first[side],
            exchanged: episode.exchanged[side],
        };
        let [first, second] = hits(&outcome, &party(b, one, 1), &party(a, two, 0));
        let each = [(over(one), first), (over(two), second)];
        each.into_iter().filter(|(over, _)| *over).map(|(_, hit)| hit).collect()
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::Material;
    use cullet_geometry::{Pose, Solid, TriMesh};
    use std::sync::Arc;

    /// A tetrahedron around the origin.
    fn spec() -> BodySpec {
        let corner = |x, y, z| Vec3::new(x, y, z) * 0.1;
        let vertices = vec![
            corner(1.0, 1.0, 1.0),
            corner(1.0, -1.0, -1.0),
            corner(-1.0, 1.0, -1.0),
            corner(-1.0, -1.0, 1.0),
        ];
        let triangles = vec![[0, 1, 2], [0, 3, 1], [0, 2, 3], [1, 3, 2]];
        BodySpec {
            name: "tetrahedron".into(),
            density: None,
            hulls: vec![vertices.clone()],
            solid: Arc::new(Solid::outer(TriMesh { vertices, triangles })),
            material: Material {
                density: 1000.0,
                young: 1e9,
                poisson: 0.2,
                failure_stress: 1e6,
                fracture_energy: 10.0,
                restitution: 0.2,
                friction: 0.5,
            },
            pose: Pose::identity(),
            velocity: Vec3::zeros(),
            spin: Vec3::zeros(),
            fixed: false,
            breakable: true,
            weakest: 1.0,
            threshold: None,
            parent: None,
            generation: 0,
            original_volume: None,
        }
    }

    #[test]
    fn a_motion_that_is_no_number_ends_the_run_by_name() {
        let mut world = World::new(WorldSettings::default()).unwrap();
        let id = world.insert(spec()).unwrap();
        world.step().unwrap();
        world.rigid.set_velocity(id.0, &Vec3::new(f64::NAN, 0.0, 0.0), &Vec3::zeros());
        let error = world.step().unwrap_err();
        assert_eq!(error, WorldError::NotFinite { name: "tetrahedron".into(), step: 2 });
    }

    #[test]
    fn a_body_that_does_not_follow_its_velocity_ends_the_run_by_name() {
        let free = WorldSettings { gravity: Vec3::zeros(), ..WorldSettings::default() };
        let mut world = World::new(free).unwrap();
        let velocity = Vec3::new(3.0, 0.0, -4.0);
        let held = world.insert(BodySpec { velocity, ..spec() }).unwrap();
        world.step().unwrap();
        world.rigid.held = Some(held.0);
        (0..4).for_each(|_| assert!(world.step().unwrap().is_empty()));
        let error = world.step().unwrap_err();
        let (name, due) = ("tetrahedron".into(), 5.0 * 5.0 / 240.0);
        let WorldError::Frozen { due: found, .. } = error else { panic!("{error}") };
        assert!((found - due).abs() < 1e-12, "{found} of {due} m");
        let wanted = WorldError::Frozen { name, step: 6, velocity, moved: 0.0, due: found };
        assert_eq!(error, wanted);
        let told = error.to_string();
        for word in ["\"tetrahedron\"", "step 6", "(3.000, 0.000, -4.000) m/s", "1.042e-1 m"] {
            assert!(told.contains(word), "{told}");
        }
    }

    #[test]
    fn a_free_fall_is_a_free_fall() {
        let mut world = World::new(WorldSettings::default()).unwrap();
        let id = world.insert(spec()).unwrap();
        (0..240).for_each(|_| assert!(world.step().unwrap().is_empty()));
        let body = world.body(id).unwrap();
        assert!((body.velocity.z + 9.81).abs() < 1e-9, "{}", body.velocity);
        // Semi-implicit Euler with 8 substeps falls too far by g t dt / 2 / 8.
        assert!((body.pose.translation.z + 4.905).abs() < 5e-3, "{}", body.pose.translation);
        assert!((world.time() - 1.0).abs() < 1e-12 && world.step_count() == 240);
    }
}
