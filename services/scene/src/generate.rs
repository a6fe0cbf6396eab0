//! Many bodies from one template: rows, stacks, and bodies strewn by a seed.

use super::body::BodyTemplate;
use super::context::ResolveContext;
use super::format::{Body, Grid, ObjectsChoice, Scatter, Stack};
use cullet_document::tree::{Path, join};
use cullet_geometry::math::{scramble, unit};
use cullet_geometry::{Pose, Quat, Vec3};

/// Tries for each strewn body before the box counts as full.
const TRIES: u64 = 2000;

/// A body of a generator: its name, and its place in place of the template's.
pub(super) struct Instance {
    pub(super) name: String,
    pub(super) position: Vec3,
    pub(super) rotation: Quat,
    /// Whether `position` is the centroid's rather than the anchor's.
    pub(super) by_centroid: bool,
}

/// How many bodies a grid makes.
pub(super) fn grid_count(grid: &Grid) -> u64 {
    grid.count.iter().fold(1_u64, |all, &count| all.saturating_mul(u64::from(count)))
}

impl Instance {
    /// Where the frame of a template is as this one.
    pub(super) fn pose(&self, template: &BodyTemplate) -> Pose {
        let anchor = if self.by_centroid { Vec3::zeros() } else { template.placement.anchor };
        let centre = self.position - self.rotation * anchor;
        Pose::from_parts(centre.into(), self.rotation)
    }
}

/// The bodies of a grid, layer by layer.
pub(super) fn grid(grid: &Grid, template: &BodyTemplate) -> Vec<Instance> {
    let [nx, ny, nz] = grid.count;
    let [dx, dy, dz] = grid.spacing;
    let mut instances = Vec::new();
    for k in 0..nz {
        let shift = if k % 2 == 1 { grid.bond * dx } else { 0.0 };
        for j in 0..ny {
            for i in 0..nx {
                let offset =
                    Vec3::new(f64::from(i) * dx + shift, f64::from(j) * dy, f64::from(k) * dz);
                instances.push(Instance {
                    name: format!("{}-{i}-{j}-{k}", grid.name),
                    position: template.placement.position + offset,
                    rotation: template.placement.rotation,
                    by_centroid: false,
                });
            }
        }
    }
    instances
}

/// The bodies of a stack, from the first on.
pub(super) fn stack(stack: &Stack, template: &BodyTemplate) -> Vec<Instance> {
    let offset = Vec3::from(stack.offset);
    let instance = |i: u32| {
        let turn = f64::from(i) * stack.twist_degrees.to_radians();
        Instance {
            name: format!("{}-{i}", stack.name),
            position: template.placement.position + f64::from(i) * offset,
            rotation: Quat::from_axis_angle(&Vec3::z_axis(), turn) * template.placement.rotation,
            by_centroid: false,
        }
    };
    (0..stack.count).map(instance).collect()
}

impl ResolveContext<'_> {
    /// The strewn bodies: the spheres around them lie in the box and do not meet.
    pub(super) fn scatter(
        &mut self,
        scatter: &Scatter,
        path: &Path,
        template: &BodyTemplate,
        world_seed: u64,
    ) -> Vec<Instance> {
        let radius = template.geometry.radius();
        let low = Vec3::from(scatter.min).add_scalar(radius);
        let room = Vec3::from(scatter.max).add_scalar(-radius) - low;
        if room.min() < 0.0 {
            let least = 2.0 * radius;
            let message = format!("the box from `min` to `max` must be at least {least:.3} m wide");
            self.unmade(&join(path, "max"), message, None);
            return Vec::new();
        }
        let stream = scatter.name.bytes().fold(0, |all, byte| scramble(all ^ u64::from(byte)));
        let seed = scatter.seed.unwrap_or(world_seed);
        let apart = 2.0 * radius + scatter.gap;
        let mut instances: Vec<Instance> = Vec::new();
        for i in 0..u64::from(scatter.count) {
            let number = |which: u64| unit(seed, stream, (i * TRIES * 4).wrapping_add(which));
            let free = (0..TRIES).find_map(|attempt| {
                let share = |axis: u64| number(attempt * 3 + axis + 3);
                let spot = low + room.component_mul(&Vec3::new(share(0), share(1), share(2)));
                let clear = instances.iter().all(|other| (other.position - spot).norm() >= apart);
                clear.then_some(spot)
            });
            let Some(position) = free else {
                let message = format!(
                    "only {i} of {} fit between `min` and `max` without meeting",
                    scatter.count
                );
                self.unmade(&join(path, "count"), message, None);
                return Vec::new();
            };
            let turn = [number(0), number(1), number(2)];
            let rotation = if scatter.turn { any_turn(turn) } else { template.placement.rotation };
            let name = format!("{}-{i}", scatter.name);
            instances.push(Instance { name, position, rotation, by_centroid: true });
        }
        instances
    }

    /// Refuses what a template must not say.
    pub(super) fn template(&mut self, body: &Body, path: &Path, placed: bool) {
        if body.name.is_some() {
            self.wrong(&join(path, "name"), "a template has no name: its generator has one");
        }
        if body.objects != ObjectsChoice::default() {
            let message = "a template is one body: `object` picks one object of a mesh file";
            self.wrong(&join(path, "objects"), message);
        }
        if !placed && body.position != [0.0; 3] {
            self.wrong(&join(path, "position"), "strewn bodies have no position: the box has");
        }
    }
}

/// A rotation from three numbers in [0, 1): even over all rotations  [Shoemake 1992].
fn any_turn([a, b, c]: [f64; 3]) -> Quat {
    let turn = std::f64::consts::TAU;
    let (minor, major) = ((1.0 - a).sqrt(), a.sqrt());
    let quaternion = nalgebra::Quaternion::new(
        libm::cos(turn * c) * major,
        libm::sin(turn * b) * minor,
        libm::cos(turn * b) * minor,
        libm::sin(turn * c) * major,
    );
    Quat::from_quaternion(quaternion)
}
