//! Rigid bodies that press on a solid of points without friction: a striker's ball or plane, and
//! the discs that it rests on.

use crate::pressed_body::{PressClock, PressedBody};
use crate::surface_particles::{SurfaceParticle, SurfaceParticles, curvature};
use cullet_geometry::{TriMesh, Vec3};
use cullet_model::hertz_contact::HertzContact;
use cullet_model::{Impact, Support};

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

/// A striker is a ball where it is curved by more than this share of the body, or of one over the
/// body's length: both curvatures are estimates \[1\].
const LEAST_CURVATURE: f64 = 0.3;

/// The shape of what presses.
#[derive(Clone, Copy, Debug, PartialEq)]
pub enum PressShape {
    /// A half-space.
    Plane,
    /// The same over a disc of that radius \[m\].
    Disc(f64),
    /// A ball of that radius \[m\].
    Ball(f64),
}

/// A rigid body that moves along its push.
#[derive(Clone, Debug)]
pub struct RigidPress {
    /// Where it touched first \[m\].
    pub point: Vec3,
    /// Unit direction into the body.
    pub normal: Vec3,
    /// What of it touches.
    pub shape: PressShape,
    /// Speed that a unit impulse takes from it \[1/kg\].
    pub mobility: f64,
    /// Along the normal \[m/s\].
    pub speed: f64,
    /// Impulse given \[N·s\].
    pub given: Vec3,
    /// Its moment about the origin \[N·m·s\].
    pub moment: Vec3,
    /// Impulse along the normal that it has left to give \[N·s\].
    pub left: f64,
    /// Energy that it has lost \[J\].
    pub lost: f64,
    /// Energy that crushing of the contact took, and what springs held of points that tore \[J\].
    pub crushed: f64,
    /// Energy in its spring now \[J\].
    pub stored: f64,
    /// When it last pushed \[s\].
    pub touched: Option<f64>,
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
    /// How deep each spring was pressed in the last step, likewise \[m\].
    pressed: Vec<f64>,
}

/// Leaves each point to the support that is nearest to it, so that they do not add up.
pub fn share_out(supports: &mut [RigidPress], points: &SurfaceParticles, body: &impl PressedBody) {
    for (k, point) in points.all.iter().enumerate() {
        let place = point.place(body);
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
    /// The striker of a hit: its mass follows from ½ m* v² = E and the `own` mobility of the body
    /// there \[1/kg\], its shape from Hertz's radius of the contact and the curvature of the body
    /// over `reach` \[m\].
    #[must_use]
    pub fn striker(hit: &Impact, own: f64, mesh: &TriMesh, reach: f64) -> Self {
        let reduced = 2.0 * hit.energy / (hit.closing_speed * hit.closing_speed);
        let mobility = (1.0 / reduced - own).max(0.0);
        let body = curvature(mesh, &hit.point, &hit.normal, reach).max(0.0);
        let striker = 1.0 / HertzContact::new(hit).relative_radius() - body;
        let shape = match striker > LEAST_CURVATURE * body.max(1.0 / mesh.diagonal()) {
            true => PressShape::Ball(1.0 / striker),
            false => PressShape::Plane,
        };
        let place = (hit.point, hit.normal);
        let mut press =
            Self::new(place, shape, (mobility, hit.closing_speed), hit.crushing_pressure);
        // It has no more to give than the world found: what it meets later is another hit.
        press.left = hit.impulse;
        press
    }

    /// What the body rests on, over a disc of at least that radius \[m\].
    #[must_use]
    pub fn support(support: &Support, least: f64) -> Self {
        let shape = PressShape::Disc(support.radius.max(least));
        let place = (support.point, support.normal);
        Self::new(place, shape, (support.mobility, 0.0), f64::INFINITY)
    }

    /// At rest; `limit` is the pressure at which the contact crushes \[Pa\].
    fn new(
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
            pressed: Vec::new(),
        }
    }

    /// Puts it beside the body at rest, as stiff as a cell of that, or as steps of `step` \[s\]
    /// bear. Where it lies a little in the body at first its spring is slack, and what it would lie
    /// deep in it does not touch.
    pub fn put(
        &mut self,
        young: f64,
        points: &SurfaceParticles,
        body: &impl PressedBody,
        step: f64,
    ) {
        let most = STABLE / (step * step * self.mobility * 0.5 * points.area);
        self.stiffness = (STIFFNESS * young / points.spacing).min(most);
        // It comes as near as it can without touching.
        let depths = points.all.iter().filter_map(|point| self.depth(&point.place(body)));
        let deepest = depths.map(|depth| depth.0).fold(f64::NEG_INFINITY, f64::max);
        if deepest < 0.0 && deepest > -points.spacing {
            self.way = -deepest;
        }
        let most = OVERLAP * points.spacing;
        let slack = |point: &SurfaceParticle| {
            let depth = self.depth(&point.place(body)).map_or(0.0, |(depth, _)| depth.max(0.0));
            if depth < most { depth } else { f64::INFINITY }
        };
        self.dents = points.all.iter().map(slack).collect();
        self.pressed = vec![0.0; self.dents.len()];
    }

    /// Takes the points behind those that it knows, which tears have laid open: what lies in it
    /// is not pushed out.
    pub fn meet(&mut self, points: &SurfaceParticles, body: &impl PressedBody) {
        self.near.extend(self.dents.len() as u32..points.all.len() as u32);
        for point in &points.all[self.dents.len()..] {
            let depth = self.depth(&point.place(body)).map_or(0.0, |(depth, _)| depth.max(0.0));
            self.dents.push(depth);
            self.pressed.push(0.0);
        }
    }

    /// Whether anything that bears lies before it and moves slower: otherwise it is through.
    #[must_use]
    pub fn comes_on(&self, points: &SurfaceParticles, body: &impl PressedBody) -> bool {
        let radius = match self.shape {
            PressShape::Plane => f64::INFINITY,
            PressShape::Disc(radius) | PressShape::Ball(radius) => radius,
        };
        points.all.iter().any(|point| {
            let Some(velocity) = body.speed_now(point.id) else { return false };
            let arm = point.place(body) - self.point;
            let along = arm.dot(&self.normal);
            let aside = (arm - self.normal * along).norm();
            // Where its front is beside its axis.
            let front = match self.shape {
                PressShape::Ball(radius) if aside < radius => {
                    self.way - radius + (radius * radius - aside * aside).sqrt()
                }
                _ => self.way,
            };
            let slower = velocity.dot(&self.normal) < self.speed;
            aside < radius && along > front && slower
        })
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

    /// Middle \[m\] and radius \[m\] of a ball, where it is now.
    #[must_use]
    pub fn ball(&self) -> Option<(Vec3, f64)> {
        let PressShape::Ball(radius) = self.shape else { return None };
        Some((self.point + self.normal * (self.way - radius), radius))
    }

    /// Finds what may be touched until the next search.
    fn search(&mut self, body: &impl PressedBody, points: &SurfaceParticles, fastest: f64) {
        let until = SEARCH as f64 * body.clock().step * (fastest + self.speed.abs());
        let margin = 2.0 * until + MARGIN * points.spacing;
        self.near.clear();
        // Those that it has met: tears lay open others.
        for (k, point) in points.all[..self.dents.len()].iter().enumerate() {
            let place = point.place(body);
            if self.depth(&place).is_some_and(|(depth, _)| depth > -margin) {
                self.near.push(k as u32);
            }
        }
    }

    /// Moves it and pushes what it touches by what falls into the body's next step; what is fastest
    /// in that moves at `fastest` \[m/s\].
    pub fn push(&mut self, body: &mut impl PressedBody, points: &SurfaceParticles, fastest: f64) {
        if self.left <= 0.0 {
            return;
        }
        let PressClock { time, step, steps } = body.clock();
        if steps.is_multiple_of(SEARCH) {
            self.search(body, points, fastest);
        }
        self.way += self.speed * step;
        let mut pushes: Vec<(u32, Vec3, Vec3)> = Vec::new();
        self.stored = 0.0;
        for &k in &self.near {
            let point: &SurfaceParticle = &points.all[k as usize];
            let place = point.place(body);
            let Some((depth, out)) = self.depth(&place) else { continue };
            let pressed = std::mem::take(&mut self.pressed[k as usize]);
            if depth > self.dents[k as usize] && body.speed_now(point.id).is_none() {
                // What its spring held goes with it.
                self.crushed += 0.5 * self.stiffness * pressed * pressed * point.area;
                continue;
            }
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
                self.pressed[k as usize] = left;
                pushes.push((k, place, out * (pressure * point.area * step)));
            }
        }
        let all: f64 = pushes.iter().map(|push| push.2.dot(&self.normal)).sum();
        let share = if all > self.left { self.left / all } else { 1.0 };
        for (k, place, push) in pushes {
            let (point, push) = (&points.all[k as usize], push * share);
            body.kick(point.id, &point.offset, &push);
            self.given += push;
            self.moment += place.cross(&push);
        }
        let along = share * all;
        self.left -= along;
        if along > 0.0 {
            self.touched = Some(time);
        }
        let before = self.speed;
        self.speed -= self.mobility * along;
        self.lost += 0.5 * (before + self.speed) * along;
    }
}
