//! From a scene to the recorder's terms.

use cullet_geometry::Vec3;
use cullet_plan::AccuracyTarget;
use cullet_record::{InteriorLook, RunMeta, Summary, View};
use cullet_scene::format::Fidelity;
use cullet_scene::{Observed, Scene, SceneBody, SceneMaterial};
use cullet_world::Replacement;
use std::collections::BTreeMap;

/// Name of the attachment that holds the `path=value` arguments of the run.
pub const OVERRIDES: &str = "overrides.txt";

/// Name of the attachment that holds every number of every material, with its unit.
const MATERIALS: &str = "materials.json";

pub(super) fn meta(scene: &Scene) -> RunMeta {
    let described = |m: &SceneMaterial| {
        let SceneMaterial { density, young, poisson, strength, fracture_energy, .. } = m;
        format!(
            "ρ {density} kg/m³, E {young} Pa, ν {poisson}, σ_f {strength} Pa, \
             G_f {fracture_energy} J/m²"
        )
    };
    let of_bodies = scene.bodies.iter().map(|body| &body.material);
    let all = of_bodies.chain(scene.moving.iter().map(|body| &body.material));
    let materials = all.map(|material| (material.name.clone(), described(material)));
    RunMeta {
        scene: scene.name.clone(),
        seed: scene.world.seed,
        version: env!("CARGO_PKG_VERSION").to_owned(),
        scene_text: scene.source_text.clone(),
        files: files(scene),
        step: scene.world.step,
        duration: scene.world.duration,
        gravity: Vec3::from(scene.world.gravity),
        materials: materials.collect::<BTreeMap<_, _>>(),
        view: scene.view.as_ref().map(|view| View {
            eye: Vec3::from(view.eye),
            target: Vec3::from(view.target),
            fov: view.field.to_degrees(),
            start: view.start,
            end: view.end,
        }),
        interiors: scene.bodies.iter().filter_map(interior).collect(),
        painted: scene.bodies.iter().filter(|body| body.is_painted()).count() as u64,
        drawings: scene.recording.drawings,
        deterministic: false,
    }
}

/// What an object looks like inside, where the scene says so.
fn interior(body: &SceneBody) -> Option<(String, InteriorLook)> {
    let look = body.interior?;
    let colour = look.colour.map(|part| part as f32);
    let roughness = look.roughness as f32;
    Some((body.name.clone(), InteriorLook { colour, roughness }))
}

/// The files of the scene, the overrides it was run with, and its materials.
fn files(scene: &Scene) -> Vec<(String, Vec<u8>)> {
    let files = scene.files.iter().map(|file| (file.key.clone(), file.bytes.to_vec()));
    let overrides = (OVERRIDES.to_owned(), scene.overrides.join("\n").into_bytes());
    let some = !scene.overrides.is_empty();
    let materials = (MATERIALS.to_owned(), scene.materials_json().into_bytes());
    files.chain(some.then_some(overrides)).chain([materials]).collect()
}

/// What a replacement kept and cost, for the recording.
pub(super) fn ledger(done: &Replacement) -> cullet_proto::recording::Ledger {
    cullet_proto::recording::Ledger {
        mass_rel_error: done.mass_rel_error,
        volume_rel_error: done.volume_rel_error,
        momentum_rel_error: done.momentum_rel_error,
        angular_momentum_rel_error: done.angular_momentum_rel_error,
        energy_before: done.energy_before,
        energy_after: done.energy_after,
        fracture_energy: done.fracture_energy,
        energy_gain_rel: done.energy_gain_rel,
    }
}

/// What a run showed, for the scene's expectations.
pub(super) fn observed(summary: &Summary, broken: &BTreeMap<String, u64>) -> Observed {
    Observed {
        fractures: summary.fractures,
        fragments: summary.fragments,
        bodies_final: summary.bodies_final,
        failed: summary.jobs.failed,
        open_fragments: summary.open_fragments,
        sheet_pieces: summary.sheets.map_or(0, |sheets| sheets.pieces),
        joints_broken: summary.directed.as_ref().map_or(0, |directed| directed.joints_broken),
        mass_rel_error: summary.ledger.mass_rel_error,
        momentum_rel_error: summary.ledger.momentum_rel_error,
        energy_gain_rel: summary.ledger.energy_gain_rel,
        sampled: summary.shares.as_ref().map(|shares| (shares.sampled, shares.sampled_mass)),
        broken: broken.clone(),
    }
}

/// What the scene asks of its solves; nothing where it asks nothing.
pub(super) fn target(fidelity: &Fidelity) -> Option<AccuracyTarget> {
    let Fidelity { error, budget_s: budget, smallest, pixel, cone, strength, .. } = *fidelity;
    fidelity.is_asked().then_some(AccuracyTarget { error, budget, smallest, pixel, cone, strength })
}
