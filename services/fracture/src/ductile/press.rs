//! Rigid bodies that press on a solid without friction: a striker's ball or plane, and the discs
//! that it rests on.

use super::surface::{SurfaceParticle, SurfaceParticles};
use crate::mpm::Domain;
use cullet_geometry::Vec3;

/// Steps between searches for what may be touched.
const SEARCH: u64 = 32;

/// A point that is farther than it can come until then, and by this share of a cell, is not looked
/// at \[1\].
const MARGIN: f64 = 0.25;

/// Pressure over depth, in E/h of a cell \[1\].
const STIFFNESS: f64 = 0.25;

/// Depth at first, in cells, beyond which nothing is touched \[1\].
const OVERLAP: f64 = 0.5;

/// Greatest ω²Δt² of what presses \[1\].
const STABLE: f64 = 0.25;

/// The shape of what presses.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(super) enum PressShape {
    /// A half-space.
    Plane,
    /// The same over a disc of that radius \[m\].
    Disc(f64),
    /// A ball of that radius \[m\].
    Ball(f64),
}

/// A rigid body that moves along its push.
#[derive(Clone, Debug)]
pub(super) struct RigidPress {
    /// Where it touched first \[m\].
    pub(super) point: Vec3,
    /// Unit direction into the body.
    pub(super) normal: Vec3,
    pub(super) shape: PressShape,
    /// Speed that a unit impulse takes from it \[1/kg\].
    pub(super) mobility: f64,
    /// Along the normal \[m/s\].
    pub(super) speed: f64,
    /// Impulse given \[N·s\], and its moment about the origin \[N·m·s\].
    pub(super) given: Vec3,
    pub(super) moment: Vec3,
    /// Impulse along the normal that it has left to give \[N·s\].
    pub(super) left: f64,
    /// Energy that it has lost \[J\].
    pub(super) lost: f64,
    /// Energy that crushing of the contact took \[J\].
    pub(super) crushed: f64,
    /// Energy in its spring now \[J\].
    pub(super) stored: f64,
    /// When it last pushed \[s\].
    pub(super) touched: Option<f64>,
    /// Pressure at which the contact crushes \[Pa\].
    limit: f64,
    /// How far it has moved \[m\].
    way: f64,
    /// Pressure over depth \[Pa/m\].
    stiffness: f64,
    /// What may be touched, by place in the list of points.
    near: Vec<u32>,
    /// How deep each touched point's spring was crushed, by place in the list \[m\].
    dents: Vec<f64>,
}

/// Leaves each point to the support that is nearest to it, so that they do not add up.
pub(super) fn share_out(supports: &mut [RigidPress], points: &SurfaceParticles, domain: &Domain) {
    for (k, point) in points.all.iter().enumerate() {
        let place = point.place(domain);
        let far = |it: &RigidPress| (place - it.point).norm_squared();
        let holds = |it: &&RigidPress| it.dents[k].is_finite() && it.depth(&place).is_some();
        let holding = supports.iter().enumerate().filter(|(_, it)| holds(it));
        let nearest = holding.min_by(|a, b| far(a.1).total_cmp(&far(b.1))).map(|one| one.0);
        for (n, support) in supports.iter_mut().enumerate() {
            if Some(n) != nearest {
                support.dents[k] = f64::INFINITY;
            }
        }
    }
}

impl RigidPress {
    /// At rest; `limit` is the pressure at which the contact crushes \[Pa\].
    pub(super) fn new(
        (point, normal): (Vec3, Vec3),
        shape: PressShape,
        (mobility, speed): (f64, f64),
        limit: f64,
    ) -> Self {
        Self {
            point,
            normal,
            shape,
            mobility,
            speed,
            given: Vec3::zeros(),
            moment: Vec3::zeros(),
            left: f64::INFINITY,
            lost: 0.0,
            crushed: 0.0,
            stored: 0.0,
            touched: None,
            limit,
            way: 0.0,
            stiffness: 0.0,
            near: Vec::new(),
            dents: Vec::new(),
        }
    }

    /// Puts it beside the body at rest, as stiff as a cell of that, or as steps of `step` \[s\]
    /// bear. Where it lies a little in the body at first its spring is slack, and what it would lie
    /// deep in it does not touch.
    pub(super) fn put(
        &mut self,
        young: f64,
        points: &SurfaceParticles,
        domain: &Domain,
        step: f64,
    ) {
        let most = STABLE / (step * step * self.mobility * 0.5 * points.area);
        self.stiffness = (STIFFNESS * young / points.spacing).min(most);
        // It comes as near as it can without touching.
        let depths = points.all.iter().filter_map(|point| self.depth(&point.place(domain)));
        let deepest = depths.map(|depth| depth.0).fold(f64::NEG_INFINITY, f64::max);
        if deepest < 0.0 && deepest > -points.spacing {
            self.way = -deepest;
        }
        let most = OVERLAP * points.spacing;
        let slack = |point: &SurfaceParticle| {
            let depth = self.depth(&point.place(domain)).map_or(0.0, |(depth, _)| depth.max(0.0));
            if depth < most { depth } else { f64::INFINITY }
        };
        self.dents = points.all.iter().map(slack).collect();
    }

    /// How deep a place lies in it, and the unit direction out of it; nothing beside it.
    fn depth(&self, place: &Vec3) -> Option<(f64, Vec3)> {
        let arm = place - self.point;
        let along = arm.dot(&self.normal);
        match self.shape {
            PressShape::Plane => Some((self.way - along, self.normal)),
            PressShape::Disc(radius) => {
                let aside = arm - self.normal * along;
                (aside.norm_squared() < radius * radius).then_some((self.way - along, self.normal))
            }
            PressShape::Ball(radius) => {
                let from = arm - self.normal * (self.way - radius);
                let far = from.norm();
                (far > 0.0).then(|| (radius - far, from / far))
            }
        }
    }

    /// Finds what may be touched until the next search.
    fn search(&mut self, domain: &Domain, points: &SurfaceParticles, fastest: f64) {
        let until = SEARCH as f64 * domain.step * (fastest + self.speed.abs());
        let margin = 2.0 * until + MARGIN * points.spacing;
        self.near.clear();
        for (k, point) in points.all.iter().enumerate() {
            let place = point.place(domain);
            if self.depth(&place).is_some_and(|(depth, _)| depth > -margin) {
                self.near.push(k as u32);
            }
        }
    }

    /// Moves it and pushes what it touches by what falls into the domain's next step; the body's
    /// fastest node moves at `fastest` \[m/s\].
    pub(super) fn push(&mut self, domain: &mut Domain, points: &SurfaceParticles, fastest: f64) {
        if self.left <= 0.0 {
            return;
        }
        if domain.steps.is_multiple_of(SEARCH) {
            self.search(domain, points, fastest);
        }
        let step = domain.step;
        self.way += self.speed * step;
        let mut pushes: Vec<(u32, Vec3, Vec3)> = Vec::new();
        self.stored = 0.0;
        for &k in &self.near {
            let point: &SurfaceParticle = &points.all[k as usize];
            let place = point.place(domain);
            let Some((depth, out)) = self.depth(&place) else { continue };
            let dent = &mut self.dents[k as usize];
            let most = self.limit / self.stiffness;
            if depth - *dent > most && dent.is_finite() {
                // The contact gives way, and stays as it is.
                self.crushed += self.limit * point.area * (depth - *dent - most);
                *dent = depth - most;
            }
            let left = depth - *dent;
            if left > 0.0 {
                let pressure = self.stiffness * left;
                self.stored += 0.5 * pressure * left * point.area;
                pushes.push((k, place, out * (pressure * point.area * step)));
            }
        }
        let all: f64 = pushes.iter().map(|push| push.2.dot(&self.normal)).sum();
        let share = if all > self.left { self.left / all } else { 1.0 };
        for (k, place, push) in pushes {
            let (point, push) = (&points.all[k as usize], push * share);
            domain.kick(point.id, &point.offset, &push);
            self.given += push;
            self.moment += place.cross(&push);
        }
        let along = share * all;
        self.left -= along;
        if along > 0.0 {
            self.touched = Some(domain.time);
        }
        let before = self.speed;
        self.speed -= self.mobility * along;
        self.lost += 0.5 * (before + self.speed) * along;
    }
}
