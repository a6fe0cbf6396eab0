//! The materials of a scene as JSON, for those who read its recording.

use super::format::{Layers, WeakPlane};
use super::material::SceneMaterial;
use super::scene::Scene;
use cullet_model::{Hardening, Interlayer, JohnsonCook, Treatment};
use serde_json::{Map, Value, json};

impl Scene {
    /// Every material that a body or a sheet of the scene is made of, by name: each number with its
    /// unit, 1 for those that have none. A preset that the scene changed has the values of the
    /// scene.
    #[must_use]
    pub fn materials_json(&self) -> String {
        let of_bodies = self.bodies.iter().map(|body| &*body.material);
        let materials = of_bodies.chain(self.moving.iter().map(|body| &*body.material));
        let all: Map<String, Value> =
            materials.map(|material| (material.name.clone(), numbers(material))).collect();
        format!("{:#}\n", Value::Object(all))
    }
}

fn numbers(material: &SceneMaterial) -> Value {
    let measured = [
        ("density", material.density, "kg/m³"),
        ("young", material.young, "Pa"),
        ("poisson", material.poisson, "1"),
        ("strength", material.strength, "Pa"),
        ("fracture_energy", material.fracture_energy, "J/m²"),
        ("weibull", material.weibull, "1"),
        ("restitution", material.restitution, "1"),
        ("friction", material.friction, "1"),
        ("hardness", material.surface.hardness, "Pa"),
        ("crack_friction", material.surface.friction, "1"),
    ];
    let mut object: Map<String, Value> = measured
        .map(|(key, value, unit)| (key.to_owned(), quantity(value, unit)))
        .into_iter()
        .collect();
    object.insert("breakable".to_owned(), json!(material.breakable));
    if let Some(length) = material.correlation {
        object.insert("correlation".to_owned(), quantity(length, "m"));
    }
    if let Some(WeakPlane { normal, ratio }) = material.weak_plane {
        let plane = json!({"normal": quantity(normal, "1"), "ratio": quantity(ratio, "1")});
        object.insert("weak_plane".to_owned(), plane);
    }
    if let Some(Layers { normal, thickness, ratio, jitter }) = material.layers {
        let layers = json!({
            "normal": quantity(normal, "1"),
            "thickness": quantity(thickness, "m"),
            "ratio": quantity(ratio, "1"),
            "jitter": quantity(jitter, "1"),
        });
        object.insert("layers".to_owned(), layers);
    }
    if let Some(treatment) = &material.treatment {
        let mut numbers = Map::new();
        numbers.insert("kind".to_owned(), json!(treatment.kind()));
        match treatment {
            Treatment::Laminated { interlayer } => {
                let Interlayer { thickness, strength, stretch } = *interlayer;
                numbers.insert("thickness".to_owned(), quantity(thickness, "m"));
                numbers.insert("strength".to_owned(), quantity(strength, "Pa"));
                numbers.insert("stretch".to_owned(), quantity(stretch, "1"));
            }
            other => {
                let stress = quantity(other.surface_stress(), "Pa");
                numbers.insert("surface_stress".to_owned(), stress);
            }
        }
        object.insert("treatment".to_owned(), Value::Object(numbers));
    }
    if let Some(flow) = &material.plasticity {
        let numbers = flow_numbers(flow);
        object.insert("plasticity".to_owned(), Value::Object(numbers));
    }
    Value::Object(object)
}

fn flow_numbers(flow: &JohnsonCook) -> Map<String, Value> {
    let Hardening { yield_stress, hardening, exponent } = flow.hardening;
    let mut numbers = Map::new();
    let mut put = |key: &str, value: Value| numbers.insert(key.to_owned(), value);
    put("yield_stress", quantity(yield_stress, "Pa"));
    put("hardening", quantity(hardening, "Pa"));
    put("exponent", quantity(exponent, "1"));
    if flow.rate > 0.0 {
        put("rate", quantity(flow.rate, "1"));
        put("reference_rate", quantity(flow.reference_rate, "1/s"));
    }
    if let Some(heat) = flow.softening {
        let softening = json!({
            "melting": quantity(heat.melting, "K"),
            "exponent": quantity(heat.exponent, "1"),
            "heat_capacity": quantity(heat.heat_capacity, "J/(kg K)"),
            "heat_share": quantity(heat.heat_share, "1"),
        });
        put("softening", softening);
    }
    if let Some(failure) = flow.failure {
        put("failure", quantity(failure.d, "1"));
    }
    numbers
}

fn quantity(value: impl serde::Serialize, unit: &str) -> Value {
    json!({"value": value, "unit": unit})
}
