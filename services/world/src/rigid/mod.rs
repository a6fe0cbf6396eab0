//! The rigid-body engine behind our own words: the only folder that names rapier, parry or glam.

mod ccd;
mod contacts;
mod convert;
mod engine_joints;
mod fused;
mod hulls;
mod joints;
mod patch;
mod relax;
mod rest;
mod saved;
mod seams;
mod shape;
mod suppressed;
mod sweep;
mod touching;
mod windows;

pub(crate) use contacts::Contact;
pub(crate) use hulls::Fit;
pub use hulls::hulls_overlap;
pub(crate) use patch::Patch;
pub(crate) use shape::{BadPart, Shape};

use crate::body::Body;
use crate::motion::{Motion, least_speed};
use crate::path::KeyframedPath;
use crate::settings::WorldSettings;
use ccd::{CcdSolver, Push, set_back};
use convert::{engine_pose, mass_properties, pose, vec3, vector};
use cullet_geometry::{Mat3, Vec3};
use engine_joints::EngineJoints;
use hulls::Part;
use rapier3d_f64::prelude::{
    ActiveHooks, Collider, ColliderBuilder, IntegrationParameters, PhysicsWorld, QueryFilter,
    QueryFilterFlags, Ray, RigidBody, RigidBodyBuilder, RigidBodyHandle, SpringCoefficients,
};
use rest::{StillBody, Stillness};
use seams::{HeldBalls, seam_room};
use std::collections::BTreeMap;
use std::panic::{AssertUnwindSafe, catch_unwind};
use std::sync::Arc;
use suppressed::{Placed, StepHooks, SuppressedPairs};
use sweep::{SweepContext, SweptBody, SweptKind};

/// Contact stiffness between moving bodies \[Hz\]: at 240 steps of 8 iterations a stack of 10 sags
/// by 0.6 mm and a slice under 100 times its mass by 0.9 mm; at half the stiffness by 1.8 mm and
/// 3.6 mm.
const CONTACT_HZ: f64 = 240.0;
/// Contact stiffness against fixed bodies \[Hz\].
const STATIC_CONTACT_HZ: f64 = 480.0;
/// Stiffness times the solver's substep must stay below this, or contacts ring and stacks topple.
const STIFFEST: f64 = 0.25;
/// Damping ratio of contacts: the engine's own.
const CONTACT_DAMPING: f64 = 10.0;
/// Overlaps are pushed apart no faster than this (F34) \[m/s\].
const DEPENETRATION_SPEED: f64 = 0.2;
/// Speed at which the engine would cap a body \[m/s\]: beyond anything a scene may ask for.
const SPEED_CAP: f64 = 2e6;
/// A body that moves more than this share of its thickness in a step is stopped where it touches,
/// not where the step ends (F42) …
const SWEEP_SHARE: f64 = 0.25;
/// … and one of the scene that moves more than this share, so that a hard landing does not sink in.
const LANDING_SHARE: f64 = 0.02;
/// A body that in the last step moved less than this share of what its velocity asked for was
/// caught by what it met \[1\] …
const CAUGHT_SHARE: f64 = 0.5;
/// … if it was, and still is, faster than this \[m/s\].
const CAUGHT_SPEED: f64 = 0.2;
/// Fragments slower than this are damped; above twice of it they no longer are \[m/s\].
const DAMPED_SPEED: f64 = 0.2;
/// Suppressed pairs are reviewed every so many steps.
const REVIEW_EVERY: u64 = 4;
/// Fragments within this share of their size are looked at for overlap at birth.
const NEAR: f64 = 1.01;

struct Slot {
    handle: RigidBodyHandle,
    parts: Vec<Part>,
    reach: f64,
    thickness: f64,
    fixed: bool,
    /// \[kg\]
    mass: f64,
    /// About the centre, own frame \[kg·m²\].
    inertia: Mat3,
    /// It moves along this path alone.
    driven: Option<Arc<KeyframedPath>>,
    fit: Fit,
    /// Damping when slow \[1/s\]; zero for bodies that keep what they have.
    damping: f64,
    damped: bool,
    rest: Stillness,
}

/// The engine failed (it panicked); nothing in it is to be trusted.
pub(crate) struct Broken;

/// The engine and the bodies in it, by our ids.
pub(crate) struct Rigid {
    world: PhysicsWorld,
    slots: BTreeMap<u32, Slot>,
    suppressed: SuppressedPairs,
    joints: EngineJoints,
    /// Motions before the last step, in id order.
    before: Vec<(u32, Motion)>,
    prior: Vec<(u32, Motion)>,
    /// Impulses of the last step between bodies whose cores met.
    pushes: Vec<Push>,
    /// Bodies that the last step set back to where they met others.
    set_back: Vec<u32>,
    steps: u64,
    /// A body that a test holds in its place while its velocity runs on.
    #[cfg(test)]
    pub(crate) held: Option<u32>,
}

impl Rigid {
    pub(crate) fn new(settings: &WorldSettings) -> Self {
        let most = STIFFEST * settings.iterations as f64 / settings.step;
        let stiff = |hz: f64| SpringCoefficients::new(hz.min(most), CONTACT_DAMPING);
        let unit = settings.length_unit;
        let world = PhysicsWorld {
            gravity: vector(&settings.gravity),
            integration_parameters: IntegrationParameters {
                dt: settings.step,
                length_unit: unit,
                num_solver_iterations: settings.iterations,
                max_ccd_substeps: 0,
                contact_softness: stiff(CONTACT_HZ),
                static_contact_softness: stiff(STATIC_CONTACT_HZ),
                normalized_max_corrective_velocity: DEPENETRATION_SPEED / unit,
                normalized_max_linear_velocity: SPEED_CAP / unit,
                ..IntegrationParameters::default()
            },
            ..PhysicsWorld::default()
        };
        Self {
            world,
            slots: BTreeMap::new(),
            suppressed: SuppressedPairs::default(),
            joints: EngineJoints::default(),
            before: Vec::new(),
            prior: Vec::new(),
            pushes: Vec::new(),
            set_back: Vec::new(),
            steps: 0,
            #[cfg(test)]
            held: None,
        }
    }

    /// Puts a body in; `damping` \[1/s\] acts on it only when it is slow.
    pub(crate) fn insert(
        &mut self,
        id: u32,
        body: &Body,
        shape: Shape,
        motion: &Motion,
        damping: f64,
    ) {
        let Shape { parts, fit } = shape;
        let builder = match &body.driven {
            Some(_) => RigidBodyBuilder::kinematic_position_based(),
            None if body.fixed => RigidBodyBuilder::fixed(),
            None => RigidBodyBuilder::dynamic(),
        };
        let mut rigid = builder
            .pose(engine_pose(&motion.pose))
            .linvel(vector(&motion.velocity))
            .angvel(vector(&motion.spin))
            .additional_mass_properties(mass_properties(body.mass, &body.inertia))
            .allow_fast_rotation(true)
            .gyroscopic_forces_enabled(true)
            .user_data(u128::from(id))
            .build();
        // Whether it rests is found out here (`rest`).
        rigid.activation_mut().normalized_linear_threshold =
            SPEED_CAP / self.world.integration_parameters.length_unit;
        let handle = self.world.insert_body(rigid);
        for part in &parts {
            let collider = ColliderBuilder::new(part.shape.clone())
                .density(0.0)
                .friction(body.material.friction)
                .restitution(body.material.restitution)
                .active_hooks(
                    ActiveHooks::FILTER_CONTACT_PAIRS | ActiveHooks::MODIFY_SOLVER_CONTACTS,
                );
            self.world.insert_collider(collider, Some(handle));
        }
        let slot = Slot {
            handle,
            parts,
            reach: body.reach,
            thickness: body.thickness,
            fixed: body.fixed,
            mass: body.mass,
            inertia: body.inertia,
            driven: body.driven.clone(),
            fit,
            damping,
            damped: false,
            rest: Stillness::default(),
        };
        self.slots.insert(id, slot);
        // New mass properties reach the engine's solver at the next step; make them known at once.
        if let Some(rigid) = self.world.bodies.get_mut(handle) {
            rigid.recompute_mass_properties_from_colliders(&self.world.colliders);
        }
    }

    pub(crate) fn remove(&mut self, id: u32) {
        if let Some(slot) = self.slots.remove(&id) {
            self.world.remove_body(slot.handle);
        }
        self.suppressed.forget(id);
    }

    /// Where a body is and how it moves, as the engine has it.
    pub(crate) fn motion(&self, id: u32) -> Option<Motion> {
        self.slots.get(&id).and_then(|slot| self.read(slot.handle))
    }

    /// Share of a way \[1\] after which something that never moves is met, if it is.
    pub(crate) fn fixed_on_the_way(&self, from: &Vec3, way: &Vec3) -> Option<f64> {
        let ray = Ray::new(vector(from), vector(way));
        let filter = QueryFilter { flags: QueryFilterFlags::ONLY_FIXED, ..QueryFilter::default() };
        self.world.cast_ray(&ray, 1.0, true, filter).map(|(_, share)| share)
    }

    fn read(&self, handle: RigidBodyHandle) -> Option<Motion> {
        self.world.bodies.get(handle).map(|body| Motion {
            pose: pose(body.position()),
            velocity: vec3(body.linvel()),
            spin: vec3(body.angvel()),
        })
    }

    /// Damping that acts on a body now \[1/s\].
    pub(crate) fn damping(&self, id: u32) -> f64 {
        self.slots.get(&id).map_or(0.0, |slot| if slot.damped { slot.damping } else { 0.0 })
    }

    pub(crate) fn sleeping(&self, id: u32) -> bool {
        let body = self.slots.get(&id).and_then(|slot| self.world.bodies.get(slot.handle));
        body.is_some_and(RigidBody::is_sleeping)
    }

    /// Gives a body a velocity \[m/s\] and a spin \[rad/s\], and wakes it.
    pub(crate) fn set_velocity(&mut self, id: u32, velocity: &Vec3, spin: &Vec3) {
        let handle = self.slots.get(&id).map(|slot| slot.handle);
        if let Some(body) = handle.and_then(|h| self.world.bodies.get_mut(h)) {
            body.set_linvel(vector(velocity), true);
            body.set_angvel(vector(spin), true);
        }
    }

    /// Lets bodies that rest after a step sleep, and no others.
    fn let_sleep(&mut self) {
        let step = self.world.integration_parameters.dt;
        let gravity = vec3(self.world.gravity);
        for ((_, before), slot) in self.before.iter().zip(self.slots.values_mut()) {
            if let Some(body) = self.world.bodies.get_mut(slot.handle) {
                let of = StillBody { reach: slot.reach, mass: slot.mass, gravity, step };
                slot.rest.let_sleep(body, before, &of);
            }
        }
    }

    /// One step of the engine.
    pub(crate) fn step(&mut self) -> Result<(), Broken> {
        std::mem::swap(&mut self.prior, &mut self.before);
        self.before.clear();
        self.pushes.clear();
        self.set_back.clear();
        for (&id, slot) in &self.slots {
            if let Some(motion) = self.read(slot.handle) {
                self.before.push((id, motion));
            }
        }
        self.drive();
        self.prepare_fused();
        self.choose_damped();
        let done = catch_unwind(AssertUnwindSafe(|| {
            let of = &self.world.integration_parameters;
            let (step, room) = (of.dt, seam_room(of, self.world.gravity));
            let held = HeldBalls::of(&self.world);
            let hooks = StepHooks { suppressed: &self.suppressed, held, step, room };
            self.world.step_with_events(&hooks, &());
            let held = hooks.held;
            self.set_back_where_they_meet(&held);
            self.move_as_one();
            self.let_sleep();
        }));
        #[cfg(test)]
        self.hold();
        self.steps += 1;
        if self.steps.is_multiple_of(REVIEW_EVERY) {
            self.review_suppressed();
        }
        done.map_err(|_| Broken)
    }

    #[cfg(test)]
    fn hold(&mut self) {
        let held = self.held.and_then(|id| Some((self.slots.get(&id)?.handle, *self.before(id)?)));
        if let Some((handle, before)) = held
            && let Some(body) = self.world.bodies.get_mut(handle)
        {
            set_back(body, engine_pose(&before.pose));
        }
    }

    /// Sends the driven bodies on along their paths; over the step they move at the velocity that
    /// takes them there.
    fn drive(&mut self) {
        let dt = self.world.integration_parameters.dt;
        let (now, then) = (self.steps as f64 * dt, (self.steps + 1) as f64 * dt);
        for ((_, before), slot) in self.before.iter_mut().zip(self.slots.values()) {
            let Some(path) = &slot.driven else { continue };
            (before.velocity, before.spin) = path.velocity(now, then - now);
            if let Some(body) = self.world.bodies.get_mut(slot.handle) {
                body.set_next_kinematic_position(engine_pose(&path.at(then)));
            }
        }
    }

    /// Motion before the last step.
    pub(crate) fn before(&self, id: u32) -> Option<&Motion> {
        let place = self.before.binary_search_by_key(&id, |(id, _)| *id).ok()?;
        Some(&self.before[place].1)
    }

    /// Share of the step before the last that a body moved for \[1\]: one that meets another stops
    /// where they touch, and has the gravity of the whole step.
    pub(crate) fn moved(&self, id: u32) -> f64 {
        let Ok(place) = self.prior.binary_search_by_key(&id, |(id, _)| *id) else {
            return 1.0;
        };
        let (prior, Some(now)) = (&self.prior[place].1, self.before(id)) else {
            return 1.0;
        };
        let path = (now.centre() - prior.centre()).dot(&now.velocity);
        let whole = now.velocity.norm_squared() * self.world.integration_parameters.dt;
        if whole > 0.0 { (path / whole).clamp(0.0, 1.0) } else { 1.0 }
    }

    /// Did a body not follow its velocity over the step before this one, and has it still?
    fn caught(&self, id: u32) -> bool {
        let Ok(place) = self.prior.binary_search_by_key(&id, |(id, _)| *id) else {
            return false;
        };
        let (prior, Some(now)) = (&self.prior[place].1, self.before(id)) else {
            return false;
        };
        let speed = least_speed(prior, now);
        let moved = (now.centre() - prior.centre()).norm();
        let due = speed * self.world.integration_parameters.dt;
        speed > CAUGHT_SPEED && moved < CAUGHT_SHARE * due
    }

    /// The first body that the engine took out because its motion is not finite.
    pub(crate) fn quarantined(&self) -> Option<u32> {
        let quarantine = self.world.quarantine();
        let bodies = quarantine.bodies().iter().copied();
        let parents = quarantine
            .colliders()
            .iter()
            .filter_map(|c| self.world.colliders.get(*c).and_then(Collider::parent));
        bodies
            .chain(parents)
            .filter_map(|handle| self.world.bodies.get(handle))
            .map(|body| body.user_data as u32)
            .min()
    }

    /// Bodies that met within the step are set back to where they then are (F42).
    fn set_back_where_they_meet(&mut self, balls: &HeldBalls) {
        let moving = self.before.iter().zip(&self.slots);
        let swept = moving.filter_map(|((_, before), (&id, slot))| {
            let body = self.world.bodies.get(slot.handle)?;
            if !body.position().translation.is_finite() {
                return None;
            }
            let (kind, share) = match slot.fit {
                _ if slot.fixed => (SweptKind::Fixed, SWEEP_SHARE),
                _ if slot.driven.is_some() => (SweptKind::Driven, SWEEP_SHARE),
                Fit::Tiny => (SweptKind::Tiny, SWEEP_SHARE),
                Fit::Fragment => (SweptKind::Moving, SWEEP_SHARE),
                Fit::Body => (SweptKind::Moving, LANDING_SHARE),
            };
            let which = (id, slot.handle, body);
            let before = engine_pose(&before.pose);
            let mut swept =
                SweptBody::new(which, &slot.parts, (kind, share * slot.thickness), &before);
            swept.caught = self.caught(id);
            Some(swept)
        });
        let swept: Vec<SweptBody<'_>> = swept.collect();
        if !swept.iter().any(SweptBody::far) {
            return;
        }
        let of = &self.world.integration_parameters;
        let slop = of.allowed_linear_error();
        let room = seam_room(of, self.world.gravity);
        let (touching, step) = (&self.world.narrow_phase, of.dt);
        let context =
            SweepContext { suppressed: &self.suppressed, touching, balls, slop, room, step };
        let met = CcdSolver::new(swept).solve(&context);
        for (handle, velocity, spin) in met.motions {
            if let Some(body) = self.world.bodies.get_mut(handle) {
                body.set_linvel(velocity, true);
                body.set_angvel(spin, true);
            }
        }
        for (handle, pose) in self.with_joined(met.ends) {
            if let Some(body) = self.world.bodies.get_mut(handle) {
                self.set_back.push(body.user_data as u32);
                set_back(body, pose);
            }
        }
        self.pushes = met.pushes;
    }

    /// Slow fragments that touch something are damped, so that heaps come to rest; those that fly
    /// are not.
    fn choose_damped(&mut self) {
        for ((_, motion), slot) in self.before.iter().zip(self.slots.values_mut()) {
            if slot.damping == 0.0 {
                continue;
            }
            let speed = motion.velocity.norm() + motion.spin.norm() * slot.reach;
            let slow = speed < if slot.damped { 2.0 * DAMPED_SPEED } else { DAMPED_SPEED };
            let damped = slow && touching::is_touching(&self.world, slot.handle);
            if damped != slot.damped {
                slot.damped = damped;
                let damping = if damped { slot.damping } else { 0.0 };
                if let Some(body) = self.world.bodies.get_mut(slot.handle) {
                    body.set_linear_damping(damping);
                    body.set_angular_damping(damping);
                }
            }
        }
    }

    fn placed(&self, id: u32) -> Option<Placed<'_>> {
        let slot = self.slots.get(&id)?;
        let pose = self.read(slot.handle)?.pose;
        Some(Placed { parts: &slot.parts, pose })
    }

    /// Marks the newborn that overlap each other or those that broke their parent (ids in rising
    /// order, the newborn last).
    pub(crate) fn suppress_contacts(&mut self, newborn: &[u32], strikers: &[u32]) {
        let mut suppressed = std::mem::take(&mut self.suppressed);
        for (k, &b) in newborn.iter().enumerate() {
            for &a in strikers.iter().chain(&newborn[..k]) {
                if !self.near(a, b) {
                    continue;
                }
                if let (Some(pa), Some(pb)) = (self.placed(a), self.placed(b)) {
                    suppressed.admit((a, b), &pa, &pb);
                }
            }
        }
        self.suppressed = suppressed;
    }

    /// Do the balls around two bodies meet?
    fn near(&self, a: u32, b: u32) -> bool {
        let ball = |id: u32| {
            let slot = self.slots.get(&id)?;
            Some((self.read(slot.handle)?.centre(), slot.reach))
        };
        match (ball(a), ball(b)) {
            (Some((ca, ra)), Some((cb, rb))) => (ca - cb).norm() < NEAR * (ra + rb),
            _ => false,
        }
    }

    fn review_suppressed(&mut self) {
        let mut pairs = std::mem::take(&mut self.suppressed.pairs);
        pairs.retain(|&(a, b), limit| {
            if self.sleeping(a) && self.sleeping(b) {
                return true;
            }
            match (self.placed(a), self.placed(b)) {
                (Some(pa), Some(pb)) => SuppressedPairs::keeps(*limit, &pa, &pb),
                _ => false,
            }
        });
        self.suppressed.pairs = pairs;
    }
}
