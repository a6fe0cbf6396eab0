//! From a scene to the terms of the rigid world.

use super::material::SceneMaterial;
use super::scene::{Scene, SceneBody};
use cullet_geometry::Vec3;
use cullet_model::Material;
use cullet_world::{BodySpec, ContactMaterial, Tiers, WorldSettings};

/// The engine's tolerances scale with this share of the typical size of a moving body: the size of
/// its fragments.
const LENGTH_SHARE: f64 = 0.2;
/// Bounds of that length \[m\]: outside, the engine's slop is a grain of dust or a house.
const LENGTH_BOUNDS: (f64, f64) = (0.01, 10.0);

/// The settings of the world of a scene.
#[must_use]
pub fn world_settings(scene: &Scene) -> WorldSettings {
    let defaults = WorldSettings::default();
    WorldSettings {
        gravity: Vec3::from(scene.world.gravity),
        step: scene.world.step,
        impulse_threshold: scene.world.impulse_threshold,
        tiers: Tiers {
            tiny: scene.world.tiers.tiny,
            small: scene.world.tiers.small,
            ..defaults.tiers
        },
        max_bodies: scene.world.max_bodies as usize,
        max_generation: scene.world.max_generation,
        length_unit: length_unit(scene),
        ..defaults
    }
}

fn length_unit(scene: &Scene) -> f64 {
    let moving = scene.bodies.iter().filter(|body| !body.fixed && body.drive.is_none());
    let mut sizes: Vec<f64> = moving.map(|body| libm::cbrt(body.volume)).collect();
    sizes.sort_by(f64::total_cmp);
    let typical = sizes.get(sizes.len() / 2).copied().unwrap_or(1.0);
    (LENGTH_SHARE * typical).clamp(LENGTH_BOUNDS.0, LENGTH_BOUNDS.1)
}

/// A body as the world takes it.
#[must_use]
pub fn spec(body: &SceneBody) -> BodySpec {
    BodySpec {
        density: None,
        name: body.name.clone(),
        solid: body.solid.clone(),
        hulls: (*body.hulls).clone(),
        material: contact_material(&body.material),
        pose: body.pose,
        velocity: body.velocity,
        spin: body.spin,
        fixed: body.fixed,
        weakest: body.weakest,
        breakable: body.breakable,
        threshold: body.impulse_threshold,
        parent: None,
        generation: 0,
        original_volume: None,
        driven: body.drive.clone(),
    }
}

/// What the surface of a body of a material is like, and from which stress its hits count.
#[must_use]
pub fn contact_material(material: &SceneMaterial) -> ContactMaterial {
    ContactMaterial {
        solid: Material {
            density: material.density,
            young: material.young,
            poisson: material.poisson,
            // What decides whether a hit is worth a solve.
            failure_stress: material
                .plasticity
                .map_or(material.strength, |it| it.hardening.yield_stress),
            fracture_energy: material.fracture_energy,
        },
        restitution: material.restitution,
        friction: material.friction,
        surface: material.surface,
        flows: material.plasticity.is_some(),
    }
}
