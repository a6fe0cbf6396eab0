//! From the tree to a scene that runs: every section read, every body made and placed.

use super::body::{BodyTemplate, MAX_DISTANCE, ResolveContext};
use super::format::{self, Body, Document, Grid, Scatter, Stack};
use super::generate::{self, Instance};
use super::material::{self, SceneMaterial};
use super::taken::Taken;
use super::{Scene, SceneBody, admission, limits, overlap, paint, preflight};
use cullet_document::check::{Findings, tell};
use cullet_document::error::{SceneError, nearest, suggest};
use cullet_document::files::Files;
use cullet_document::tree::{Node, Path, join, show};
use cullet_geometry::{Pose, Vec3};
use serde::de::DeserializeOwned;
use std::collections::BTreeSet;
use std::sync::Arc;

/// Most overlapping pairs reported: the others follow from the first.
const MAX_OVERLAPS: usize = 10;

/// Longest name of a body, material or generator \[bytes\]: it becomes a topic of the recording.
pub(super) const MAX_NAME: usize = 80;

/// What was made of a tree.
pub(super) struct Resolved {
    /// The scene; only meaningful without errors.
    pub(super) scene: Scene,
    /// What is wrong.
    pub(super) errors: Vec<SceneError>,
}

/// Makes a scene of a tree that was held against the schema. What is wrong with one value keeps
/// nothing else from being looked at; `garbled`: some of the text is no TOML.
pub(super) fn resolve(
    root: &Node,
    findings: Findings,
    garbled: bool,
    files: &mut Files,
) -> Resolved {
    let mut workshop = ResolveContext::new(root, files);
    (workshop.bad, workshop.garbled) = (findings.bad, garbled);
    let document = read_sections(&mut workshop);
    materials(&mut workshop);
    let mut builder = Builder { workshop, document, bodies: Vec::new(), paths: Vec::new() };
    builder.bodies();
    builder.names();
    limits::check(&mut builder.workshop, &builder.document, builder.bodies.len());
    builder.overlaps();
    builder.finish()
}

fn read_sections(workshop: &mut ResolveContext<'_>) -> Document {
    let mut document = Document::default();
    read(workshop, "description", &mut document.description);
    read(workshop, "world", &mut document.world);
    read(workshop, "fracture", &mut document.fracture);
    read(workshop, "fidelity", &mut document.fidelity);
    read(workshop, "expect", &mut document.expect);
    read(workshop, "view", &mut document.view);
    document
}

/// A section as far as it is right.
fn read<T: DeserializeOwned>(workshop: &mut ResolveContext<'_>, key: &str, section: &mut T) {
    if let Some(node) = workshop.root.get(key)
        && let Some(taken) = workshop.take(node, &[key.into()])
    {
        *section = taken.value;
    }
}

fn materials(workshop: &mut ResolveContext<'_>) {
    for preset in material::presets() {
        workshop.materials.insert(preset.name.to_owned(), Arc::new(SceneMaterial::from(preset)));
    }
    let mut own: BTreeSet<&str> = BTreeSet::new();
    for (index, node) in workshop.root.items("material").iter().enumerate() {
        let path: Path = vec!["material".into(), index.into()];
        let name = node.get("name").and_then(Node::text).unwrap_or("");
        if !own.insert(name) {
            workshop.wrong(&join(&path, "name"), format!("a second material is called \"{name}\""));
        }
        let written = workshop.take::<format::Material>(node, &path);
        let whole = written.as_ref().is_some_and(|written| written.whole);
        let made = written.and_then(|written| own_material(workshop, &written.value, &path));
        match made.filter(|_| whole) {
            Some(made) => {
                workshop.materials.insert(name.to_owned(), Arc::new(made));
            }
            None => {
                workshop.materials.remove(name);
                workshop.spoiled_materials.insert(name.to_owned());
            }
        }
    }
}

/// The material that a document writes out, or the preset that it names and what it changes of it.
pub fn own_material(
    workshop: &mut ResolveContext<'_>,
    written: &format::Material,
    path: &Path,
) -> Option<SceneMaterial> {
    let base = match &written.preset {
        None => None,
        Some(name) => match material::preset(name) {
            Some(preset) => Some(preset),
            None => {
                let known: Vec<&str> = material::presets().iter().map(|p| p.name).collect();
                let message = format!("there is no preset \"{name}\"");
                workshop.wrong_with(&join(path, "preset"), message, suggest(name, &known));
                return None;
            }
        },
    };
    let made = match SceneMaterial::from_written(written, base) {
        Ok(made) => made,
        Err(missing) => {
            for key in missing {
                if workshop.lacks(path, &[key, "preset"]) {
                    workshop.wrong(path, format!("`{key}` is missing: give it, or a `preset`"));
                }
            }
            return None;
        }
    };
    for (key, fault) in made.directions() {
        workshop.wrong(&join(&join(path, key), "normal"), fault);
    }
    for (key, doubt) in made.doubts() {
        workshop.warnings.push(format!("{}: {}", show(&join(path, key)), doubt));
    }
    let faults = if made.breakable { made.faults() } else { Vec::new() };
    let sound = faults.is_empty();
    for (key, fault) in faults {
        workshop.wrong(&join(path, key), fault);
    }
    sound.then_some(made)
}

struct Builder<'a> {
    workshop: ResolveContext<'a>,
    document: Document,
    bodies: Vec<SceneBody>,
    /// Where each body was written.
    paths: Vec<Path>,
}

impl Builder<'_> {
    fn bodies(&mut self) {
        let root = self.workshop.root;
        for (index, node) in root.items("body").iter().enumerate() {
            let path: Path = vec!["body".into(), index.into()];
            let Some(taken) = self.workshop.take::<Body>(node, &path) else {
                continue;
            };
            let body = taken.value;
            let mould = self.mould(&body, &path);
            if body.name.is_none() && self.workshop.lacks(&path, &["name"]) {
                self.workshop.wrong(&path, "`name` is missing");
            }
            if let (Some(mould), Some(name), true) = (mould, body.name, taken.whole) {
                let instance = Instance {
                    name,
                    position: mould.position,
                    rotation: mould.rotation,
                    by_centroid: false,
                };
                self.place(&mould, vec![instance], None, &path);
            }
        }
        self.grids();
        self.stacks();
        self.scatters();
    }

    fn mould(&mut self, body: &Body, path: &Path) -> Option<BodyTemplate> {
        let defaults = self.document.fracture.clone();
        self.workshop.mould(body, path, &defaults)
    }

    fn grids(&mut self) {
        let root = self.workshop.root;
        for (index, node) in root.items("grid").iter().enumerate() {
            let path: Path = vec!["grid".into(), index.into()];
            let Some(Taken { value: grid, whole }) = self.workshop.take::<Grid>(node, &path) else {
                continue;
            };
            let template = join(&path, "body");
            self.workshop.template(&grid.body, &template, true);
            let fits = self.fits(generate::grid_count(&grid), &join(&path, "count"));
            let mould = self.mould(&grid.body, &template);
            if let Some(mould) = mould.filter(|_| fits && whole) {
                let instances = generate::grid(&grid, &mould);
                self.place(&mould, instances, Some(&grid.name), &path);
            }
        }
    }

    fn stacks(&mut self) {
        let root = self.workshop.root;
        for (index, node) in root.items("stack").iter().enumerate() {
            let path: Path = vec!["stack".into(), index.into()];
            let Some(Taken { value: stack, whole }) = self.workshop.take::<Stack>(node, &path)
            else {
                continue;
            };
            let template = join(&path, "body");
            self.workshop.template(&stack.body, &template, true);
            let fits = self.fits(stack.count.into(), &join(&path, "count"));
            let mould = self.mould(&stack.body, &template);
            if let Some(mould) = mould.filter(|_| fits && whole) {
                let instances = generate::stack(&stack, &mould);
                self.place(&mould, instances, Some(&stack.name), &path);
            }
        }
    }

    fn scatters(&mut self) {
        let root = self.workshop.root;
        for (index, node) in root.items("scatter").iter().enumerate() {
            let path: Path = vec!["scatter".into(), index.into()];
            let Some(Taken { value: scatter, whole }) = self.workshop.take::<Scatter>(node, &path)
            else {
                continue;
            };
            let template = join(&path, "body");
            self.workshop.template(&scatter.body, &template, false);
            let fits = self.fits(scatter.count.into(), &join(&path, "count"));
            let mould = self.mould(&scatter.body, &template);
            // Its places follow the seed.
            let seeded = !self.workshop.is_bad(&["world".into(), "seed".into()]);
            if let Some(mould) = mould.filter(|_| fits && whole && seeded) {
                let seed = self.document.world.seed;
                let instances = self.workshop.scatter(&scatter, &path, &mould, seed);
                self.place(&mould, instances, Some(&scatter.name), &path);
            }
        }
    }

    /// Whether so many more bodies are allowed.
    fn fits(&mut self, more: u64, path: &Path) -> bool {
        let most = u64::from(self.document.world.max_bodies);
        let count = more.saturating_add(self.bodies.len() as u64);
        if more == 0 {
            self.workshop.wrong(path, "must be at least 1 in each direction");
        } else if count > most {
            let message =
                format!("the scene would have {count} bodies; world.max_bodies is {most}");
            self.workshop.wrong(path, message);
        }
        more > 0 && count <= most
    }

    fn place(
        &mut self,
        mould: &BodyTemplate,
        instances: Vec<Instance>,
        generator: Option<&str>,
        path: &Path,
    ) {
        let farthest = instances.iter().map(|i| i.position.norm()).fold(0.0, f64::max);
        if generator.is_some() && farthest > MAX_DISTANCE {
            let (most, farthest) = (tell(MAX_DISTANCE), tell(farthest));
            let message = format!(
                "its bodies must lie within {most} m of the origin; one lies at {farthest} m"
            );
            return self.workshop.wrong(path, message);
        }
        for instance in instances {
            let anchor = if instance.by_centroid { Vec3::zeros() } else { mould.anchor };
            let centre = instance.position - instance.rotation * anchor;
            self.bodies.push(SceneBody {
                name: instance.name,
                generator: generator.map(str::to_owned),
                solid: Arc::clone(&mould.form.solid),
                hulls: Arc::clone(&mould.form.hulls),
                volume: mould.form.mass.volume,
                inertia: mould.form.mass.inertia,
                pose: Pose::from_parts(centre.into(), instance.rotation),
                velocity: mould.velocity,
                spin: mould.spin,
                material: Arc::clone(&mould.material),
                strength: Arc::clone(&mould.strength),
                weakest: paint::weakest(&mould.strength),
                fixed: mould.fixed,
                breakable: mould.breakable,
                spacing: mould.spacing,
                particles: mould.particles,
                impulse_threshold: mould.impulse_threshold,
                solver: mould.solver.clone(),
                repairs: mould.form.repairs.clone(),
            });
            self.paths.push(path.clone());
        }
    }

    /// Names are unique, not too long, and expectations name what is there.
    fn names(&mut self) {
        let mut known: BTreeSet<String> = BTreeSet::new();
        for list in ["body", "grid", "stack", "scatter"] {
            for (index, node) in self.workshop.root.items(list).iter().enumerate() {
                let path: Path = vec![list.into(), index.into(), "name".into()];
                let Some(name) = node.get("name").and_then(Node::text) else {
                    continue;
                };
                if name.trim().is_empty() || name.len() > MAX_NAME || name.contains('/') {
                    let message = format!("a name has 1 to {MAX_NAME} bytes and no slash");
                    self.workshop.wrong(&path, message);
                } else if !known.insert(name.to_owned()) {
                    self.workshop.wrong(&path, format!("a second one is called \"{name}\""));
                }
            }
        }
        let written = known.clone();
        for (body, path) in self.bodies.iter().zip(&self.paths) {
            if body.generator.is_some() && !known.insert(body.name.clone()) {
                let message = format!("makes a second body called \"{}\"", body.name);
                self.workshop.wrong(path, message);
                break;
            }
        }
        self.expected_names(&known, &written);
    }

    /// Whether a name may be that of a body which could not be made: one of a list of bodies that
    /// are not there.
    fn may_be_unmade(&self, name: &str) -> bool {
        let made: BTreeSet<&str> =
            self.bodies.iter().filter_map(|body| body.generator.as_deref()).collect();
        let lists = ["grid", "stack", "scatter"].into_iter();
        let items = lists.flat_map(|list| self.workshop.root.items(list));
        let mut lost =
            items.map(|item| item.get("name").and_then(Node::text)).filter(|generator| {
                generator.is_none_or(|generator| {
                    !made.contains(generator) && name.starts_with(generator)
                })
            });
        let nameless = self.workshop.root.items("body").iter();
        let mut nameless = nameless.map(|item| item.get("name").and_then(Node::text));
        self.workshop.garbled || lost.next().is_some() || nameless.any(|name| name.is_none())
    }

    fn expected_names(&mut self, known: &BTreeSet<String>, written: &BTreeSet<String>) {
        let expect = self.document.expect.clone();
        let lists = [("broken", &expect.broken), ("unbroken", &expect.unbroken)];
        let mut named: Vec<(Path, &String)> = Vec::new();
        for (key, list) in lists {
            for (index, name) in list.iter().enumerate() {
                named.push((vec!["expect".into(), key.into(), index.into()], name));
            }
        }
        for name in expect.min_fragments_of.keys() {
            let path = vec!["expect".into(), "min_fragments_of".into(), name.as_str().into()];
            named.push((path, name));
        }
        for (path, name) in named {
            if !known.contains(name) && !self.may_be_unmade(name) {
                let help = nearest(name, written.iter().map(String::as_str))
                    .map(|near| format!("did you mean `{near}`?"));
                let message = format!("there is no body \"{name}\"");
                self.workshop.wrong_with(&path, message, help);
            }
        }
    }

    fn overlaps(&mut self) {
        if self.workshop.garbled {
            return;
        }
        let placed: Vec<overlap::Placed<'_>> =
            self.bodies.iter().map(|body| overlap::place(&body.hulls, &body.pose)).collect();
        let both_fixed = |a: usize, b: usize| self.bodies[a].fixed && self.bodies[b].fixed;
        let pairs = overlap::overlaps(&placed, MAX_OVERLAPS, both_fixed);
        for (first, second) in pairs {
            let (one, two) = (&self.bodies[first].name, &self.bodies[second].name);
            let message = format!("\"{two}\" overlaps \"{one}\" at the start");
            let help = "bodies may touch; move one of them, or make it smaller".to_owned();
            let path = self.paths[second].clone();
            self.workshop.unmade(&join(&path, "position"), message, Some(help));
        }
    }

    fn finish(mut self) -> Resolved {
        for body in &self.bodies {
            let first = body.generator.is_none() || body.name.ends_with("-0");
            for line in body.repairs.iter().filter(|_| first) {
                self.workshop.warnings.push(format!("{}: {line}", body.name));
            }
            if let Some(line) = own_load(body, &self.document.world.gravity).filter(|_| first) {
                self.workshop.warnings.push(format!("{}: {line}", body.name));
            }
        }
        self.workshop.warnings.extend(preflight::warnings(&self.document.world, &self.bodies));
        let document = self.document;
        let scene = Scene {
            name: String::new(),
            description: document.description,
            world: document.world,
            fracture: document.fracture,
            fidelity: document.fidelity,
            bodies: self.bodies,
            expect: document.expect,
            view: document.view,
            warnings: std::mem::take(&mut self.workshop.warnings),
            source_text: String::new(),
            overrides: Vec::new(),
            main: String::new(),
            files: Vec::new(),
        };
        admission::check(&mut self.workshop, &scene, &self.paths);
        Resolved { scene, errors: self.workshop.errors }
    }
}

/// What a body's own weight or spin does to it, where that alone reaches its strength: σ_f below
/// ρgL, or ρv² of its rim (F02).
fn own_load(body: &SceneBody, gravity: &[f64; 3]) -> Option<String> {
    if body.fixed || !body.breakable {
        return None;
    }
    let gravity = Vec3::from(*gravity);
    let turned = |p: &Vec3| body.pose.rotation * p;
    let depths = body.solid.mesh.vertices.iter().map(|p| gravity.dot(&turned(p)));
    let (low, high) =
        depths.fold((f64::INFINITY, f64::NEG_INFINITY), |(l, h), d| (l.min(d), h.max(d)));
    let rims = body.solid.mesh.vertices.iter().map(|p| body.spin.cross(&turned(p)).norm_squared());
    let material = &body.material;
    let (weight, rim) =
        (material.density * (high - low), material.density * rims.fold(0.0, f64::max));
    let strength = body.weakest * material.strength;
    let (load, name) = if rim > weight { (rim, "its spin") } else { (weight, "its own weight") };
    (load > strength).then(|| {
        format!("{name} stresses it by {load:.3e} Pa, its strength is {strength:.3e} Pa (F02)")
    })
}
