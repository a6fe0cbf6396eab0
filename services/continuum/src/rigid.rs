//! Rigid bodies in a window: they touch the points of what deforms, are pushed by them, and move
//! with their own mass and inertia, so that forces go both ways inside the window.

use cullet_geometry::hull::Hull;
use cullet_geometry::{Mat3, Pose, Quat, Vec3};
use cullet_model::{Handed, Proxy, ProxyMotion, Refusal};
use nalgebra::Quaternion;

/// Most corners of a convex part.
const MOST_CORNERS: usize = 256;
/// Stiffness of a point's contact by m/dt²: ωdt is 0.45, far from where steps are unstable.
const PENALTY: f64 = 0.2;
/// Share of critical damping of a point's contact: points that touch do not bounce by themselves.
const CONTACT_DAMPING: f64 = 0.3;
/// Greatest share of a point's sliding that friction takes in a step. All of it in one step would
/// turn a light body back and forth under many points.
const GRASP: f64 = 0.5;

/// A convex part as half-spaces in the body's frame.
#[derive(Clone, Debug)]
struct HalfSpaces {
    /// Outward normals and offsets \[m\].
    planes: Vec<(Vec3, f64)>,
    low: Vec3,
    high: Vec3,
}

/// How a body moves.
#[derive(Clone, Debug)]
enum ProxyDrive {
    Free { mass: f64, inertia: Mat3, inverse: Mat3 },
    Steady,
    Led(Vec<Pose>),
}

/// A point that touches, as a body finds it.
#[derive(Clone, Copy, Debug)]
struct Touching {
    point: usize,
    /// From the body's centre \[m\].
    arm: Vec3,
    /// Out of the body.
    normal: Vec3,
    /// \[m\].
    depth: f64,
}

/// A rigid body in a window.
#[derive(Clone, Debug)]
pub struct RigidProxy {
    body: u64,
    object: Option<u32>,
    parts: Vec<HalfSpaces>,
    /// Of a ball around its centre that holds all parts \[m\].
    radius: f64,
    friction: f64,
    motion: ProxyDrive,
    place: Vec3,
    turn: Quat,
    velocity: Vec3,
    spin: Vec3,
    /// About its centre, in the world's frame, of a free body \[kg·m²/s\].
    angular_momentum: Vec3,
    /// Impulse and its moment in the step of the world so far.
    given: [Vec3; 2],
    impulses: Vec<[Vec3; 2]>,
    /// Where it was after each step of the world.
    poses: Vec<Pose>,
    /// Deepest that a point was inside of it \[m\].
    pub deepest: f64,
    touching: Vec<Touching>,
}

/// The points that a body may touch.
#[derive(Clone, Copy, Debug)]
pub struct TouchedPoints<'a> {
    /// Where they are \[m\].
    pub places: &'a [Vec3],
    /// How they move \[m/s\].
    pub velocities: &'a [Vec3],
    /// Mass that weighs, and inertia, of each \[kg\].
    pub masses: &'a [[f64; 2]],
    /// Points that are not simulated, which touch nothing; may be empty.
    pub frozen: &'a [bool],
    /// Distance below which a point touches \[m\].
    pub distance: f64,
    /// Step \[s\].
    pub dt: f64,
}

impl RigidProxy {
    /// The body as it stands at the beginning of a window of so many steps of the world.
    ///
    /// # Errors
    ///
    /// If a part has no volume, or a number does not hold.
    pub fn new(proxy: &Proxy, steps: u32, family: &'static str) -> Result<Self, Refusal> {
        let unfit = |lack: String| Refusal::Unfit { solver: family, lack };
        let body = proxy.body;
        let part = |corners: &Vec<Vec3>| {
            let hull = Hull::of(corners, MOST_CORNERS)
                .ok_or_else(|| unfit(format!("a part of body {body} has no volume")))?;
            let mut planes: Vec<(Vec3, f64)> = Vec::new();
            for (normal, offset) in hull.planes() {
                let same = |(n, o): &(Vec3, f64)| {
                    n.dot(&normal) > 1.0 - 1e-12 && (o - offset).abs() <= 1e-12 * offset.abs()
                };
                if !planes.iter().any(same) {
                    planes.push((normal, offset));
                }
            }
            let low = hull.vertices().iter().fold(hull.vertices()[0], |low, p| low.inf(p));
            let high = hull.vertices().iter().fold(low, |high, p| high.sup(p));
            Ok(HalfSpaces { planes, low, high })
        };
        let parts = proxy.parts.iter().map(part).collect::<Result<Vec<_>, Refusal>>()?;
        let radius = proxy.parts.iter().flatten().map(nalgebra::Matrix::norm).fold(0.0, f64::max);
        let numbers =
            proxy.velocity.iter().chain(&proxy.spin).chain(&proxy.pose.translation.vector);
        if !numbers.chain([&proxy.friction]).all(|c| c.is_finite()) || proxy.friction < 0.0 {
            return Err(unfit(format!("body {body} moves or rubs by numbers that do not hold")));
        }
        let motion = match &proxy.motion {
            ProxyMotion::Free { mass, inertia } => {
                let inverse = inertia.try_inverse().filter(|i| i.iter().all(|c| c.is_finite()));
                let inverse = inverse.filter(|_| *mass > 0.0 && mass.is_finite());
                let lack = || unfit(format!("body {body} has no mass or inertia"));
                let inverse = inverse.ok_or_else(lack)?;
                ProxyDrive::Free { mass: *mass, inertia: *inertia, inverse }
            }
            ProxyMotion::Steady => ProxyDrive::Steady,
            ProxyMotion::Led(poses) => {
                if poses.len() != steps as usize {
                    let all = poses.len();
                    return Err(unfit(format!("body {body} is led by {all} poses, not {steps}")));
                }
                ProxyDrive::Led(poses.clone())
            }
        };
        let mut rigid = Self {
            body,
            object: proxy.object,
            parts,
            radius,
            friction: proxy.friction,
            motion,
            place: proxy.pose.translation.vector,
            turn: proxy.pose.rotation,
            velocity: proxy.velocity,
            spin: proxy.spin,
            angular_momentum: Vec3::zeros(),
            given: [Vec3::zeros(); 2],
            impulses: Vec::new(),
            poses: Vec::new(),
            deepest: 0.0,
            touching: Vec::new(),
        };
        if let ProxyDrive::Free { inertia, .. } = &rigid.motion {
            rigid.angular_momentum = rigid.turn * (inertia * (rigid.turn.inverse() * rigid.spin));
        }
        Ok(rigid)
    }

    /// Begins a step of the world of this length \[s\]: a led body takes the way to its next pose.
    pub fn begin(&mut self, number: usize, length: f64) {
        if let ProxyDrive::Led(poses) = &self.motion {
            let next = &poses[number];
            self.velocity = (next.translation.vector - self.place) / length;
            self.spin = (next.rotation * self.turn.inverse()).scaled_axis() / length;
        }
    }

    /// Ends a step of the world: books what the body was given.
    pub fn end(&mut self, number: usize) {
        if let ProxyDrive::Led(poses) = &self.motion {
            self.place = poses[number].translation.vector;
            self.turn = poses[number].rotation;
        }
        self.impulses.push(std::mem::replace(&mut self.given, [Vec3::zeros(); 2]));
        self.poses.push(Pose::from_parts(self.place.into(), self.turn));
    }

    /// Moves freely for a time \[s\].
    pub fn drift(&mut self, dt: f64) {
        self.place += self.velocity * dt;
        if let ProxyDrive::Free { inverse, .. } = &self.motion {
            self.spin = self.turn * (inverse * (self.turn.inverse() * self.angular_momentum));
        }
        if self.spin != Vec3::zeros() {
            let half = self.spin * (0.5 * dt);
            let small = Quat::new_normalize(Quaternion::new(1.0, half.x, half.y, half.z));
            self.turn = Quat::new_normalize((small * self.turn).into_inner());
        }
    }

    /// Adds the forces on touching points to `forces` \[N\] and what they give the body, then kicks
    /// it by that and by gravity.
    ///
    /// Springs and dashpots go by the mass that a point and the body have against each other. Many
    /// points can touch a light body at once, so the body counts by what all of them together would
    /// do to it: with Λ = Σ mw over the touching points, where w is what a unit impulse there gives
    /// the body's surface, each bears 1/(1 + Λ) of its own mass. The fastest motion is then no
    /// faster than that of a point on a wall.
    pub fn touch(&mut self, points: &TouchedPoints<'_>, gravity: Vec3, forces: &mut [Vec3]) {
        let share = self.find_touching(points);
        let (mut impulse, mut moment) = (Vec3::zeros(), Vec3::zeros());
        for &Touching { point, arm, normal, depth } in &self.touching {
            self.deepest = self.deepest.max(depth);
            let mass = points.masses[point][1] * share;
            let slide = points.velocities[point] - self.velocity - self.spin.cross(&arm);
            let spring = PENALTY * mass / (points.dt * points.dt) * depth;
            let dashpot = 2.0 * CONTACT_DAMPING * PENALTY.sqrt() * mass / points.dt;
            // It never pulls.
            let push = (spring - dashpot * slide.dot(&normal)).max(0.0);
            let slide = slide - normal * slide.dot(&normal);
            let speed = slide.norm();
            let most = (self.friction * push).min(GRASP * mass * speed / points.dt);
            let rub = if speed > 0.0 { slide * (most / speed) } else { Vec3::zeros() };
            let force = normal * push - rub;
            forces[point] += force;
            impulse -= force * points.dt;
            moment -= arm.cross(&force) * points.dt;
        }
        self.given[0] += impulse;
        self.given[1] += moment;
        if let ProxyDrive::Free { mass, .. } = &self.motion {
            self.velocity += gravity * points.dt + impulse / *mass;
            self.angular_momentum += moment;
        }
    }

    /// Number of the object of the scene that it is or came from, where that is known.
    #[must_use]
    pub fn object(&self) -> Option<u32> {
        self.object
    }

    /// The points that touch it, by rising number.
    pub fn touching_points(&mut self, points: &TouchedPoints<'_>) -> impl Iterator<Item = usize> {
        self.find_touching(points);
        self.touching.iter().map(|touching| touching.point)
    }

    /// Finds the points that touch; the share of their mass that they bear, 1/(1 + Λ).
    fn find_touching(&mut self, points: &TouchedPoints<'_>) -> f64 {
        let reach = self.radius + points.distance;
        let back = self.turn.inverse().to_rotation_matrix();
        let mut touching = std::mem::take(&mut self.touching);
        touching.clear();
        let mut load = 0.0;
        for (point, place) in points.places.iter().enumerate() {
            let arm = place - self.place;
            if points.frozen.get(point) == Some(&true) || arm.norm_squared() > reach * reach {
                continue;
            }
            let Some((height, normal)) = self.nearest(back * arm, points.distance) else {
                continue;
            };
            if let ProxyDrive::Free { mass, inverse, .. } = &self.motion {
                let lever = back * arm.cross(&(self.turn * normal));
                load += points.masses[point][1] * (1.0 / mass + lever.dot(&(inverse * lever)));
            }
            let (normal, depth) = (self.turn * normal, points.distance - height);
            touching.push(Touching { point, arm, normal, depth });
        }
        self.touching = touching;
        1.0 / (1.0 + load)
    }

    /// Signed distance of a place in the body's frame, if below `distance`, and the normal there.
    fn nearest(&self, at: Vec3, distance: f64) -> Option<(f64, Vec3)> {
        let mut best: Option<(f64, Vec3)> = None;
        for part in &self.parts {
            let outside =
                (0..3).any(|k| at[k] > part.high[k] + distance || at[k] < part.low[k] - distance);
            if outside {
                continue;
            }
            let mut most = (f64::NEG_INFINITY, Vec3::zeros());
            for &(normal, offset) in &part.planes {
                let height = normal.dot(&at) - offset;
                if height > most.0 {
                    most = (height, normal);
                    if height >= distance {
                        break;
                    }
                }
            }
            if most.0 < distance && best.is_none_or(|(height, _)| most.0 < height) {
                best = Some(most);
            }
        }
        best
    }

    /// What the body was given.
    #[must_use]
    pub fn handed(&self) -> Handed {
        Handed { body: self.body, impulses: self.impulses.clone(), poses: self.poses.clone() }
    }

    /// Whether it moves and may come to a ball within a time \[s\].
    #[must_use]
    pub fn may_reach(&self, centre: Vec3, radius: f64, time: f64) -> bool {
        let stands = matches!(self.motion, ProxyDrive::Steady)
            && self.velocity == Vec3::zeros()
            && self.spin == Vec3::zeros();
        let reach = radius + self.radius + self.velocity.norm() * time;
        !stands && (centre - self.place).norm() <= reach
    }

    /// Where its centre is \[m\], and how far its parts reach from there \[m\].
    #[must_use]
    pub fn reach(&self) -> (Vec3, f64) {
        (self.place, self.radius)
    }

    /// How fast its fastest part may move \[m/s\].
    #[must_use]
    pub fn speed(&self) -> f64 {
        self.velocity.norm() + self.spin.norm() * self.radius
    }

    /// Whether its numbers are numbers.
    #[must_use]
    pub fn is_finite(&self) -> bool {
        let turn = self.turn.coords.iter();
        self.place.iter().chain(&self.velocity).chain(&self.spin).chain(turn).all(|c| c.is_finite())
    }
}

#[cfg(test)]
mod tests {
    use super::{RigidProxy, TouchedPoints};
    use cullet_geometry::{Mat3, Pose, Vec3};
    use cullet_model::{Proxy, ProxyMotion};

    fn cube(mass: f64) -> Proxy {
        let side = |k: usize, bit: usize| if k >> bit & 1 == 1 { 0.5 } else { -0.5 };
        let corners = (0..8).map(|k| Vec3::new(side(k, 0), side(k, 1), side(k, 2))).collect();
        Proxy {
            body: 1,
            object: None,
            parts: vec![corners],
            friction: 0.5,
            pose: Pose::identity(),
            velocity: Vec3::zeros(),
            spin: Vec3::zeros(),
            motion: ProxyMotion::Free { mass, inertia: Mat3::identity() * (mass / 6.0) },
        }
    }

    /// 400 points of 1 g under a cube: what a step does to it must never be more than the points
    /// can bear, however light it is.
    #[test]
    fn a_body_far_lighter_than_what_touches_it_is_not_thrown_about() {
        let dt = 1e-4;
        let rows = || (0..20).map(|k| -0.45 + 0.9 * f64::from(k) / 19.0);
        let first: Vec<Vec3> =
            rows().flat_map(|x| rows().map(move |y| Vec3::new(x, y, -0.504))).collect();
        let masses = vec![[1e-3; 2]; first.len()];
        for mass in [1.0, 1e-2, 1e-4] {
            let mut rigid = RigidProxy::new(&cube(mass), 1, "family").unwrap();
            let (mut places, mut speeds) = (first.clone(), vec![Vec3::zeros(); first.len()]);
            let mut most: f64 = 0.0;
            for _ in 0..4000 {
                rigid.drift(dt);
                places.iter_mut().zip(&speeds).for_each(|(x, v)| *x += v * dt);
                let mut forces = vec![Vec3::zeros(); places.len()];
                let points = TouchedPoints {
                    places: &places,
                    velocities: &speeds,
                    masses: &masses,
                    frozen: &[],
                    distance: 0.005,
                    dt,
                };
                rigid.touch(&points, Vec3::zeros(), &mut forces);
                speeds.iter_mut().zip(&forces).for_each(|(v, f)| *v += f * (dt / 1e-3));
                most = most.max(rigid.velocity.norm()).max(rigid.spin.norm());
            }
            // Pressed by 1 mm at the start; what a spring of that depth can give 0.4 kg of points
            // is √0.2 of a depth a step.
            let bound = 0.001 / dt;
            assert!(most < bound, "{most} of {bound} m/s with {mass} kg");
            let momentum: Vec3 = speeds.iter().sum::<Vec3>() * 1e-3 + rigid.velocity * mass;
            assert!(momentum.norm() < 1e-12, "{momentum}");
        }
    }
}
