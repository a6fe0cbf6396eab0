//! From the tree to a scene that runs: every section read, every body made and placed.

use super::body::{BodyTemplate, MAX_DISTANCE};
use super::context::ResolveContext;
use super::directions::SceneDirections;
use super::format::{self, Body, Document, Dynamics, Grid, Instances, Scatter, SheetBody, Stack};
use super::generate::{self, Instance};
use super::material::{self, SceneMaterial};
use super::moving::SceneMovingBody;
use super::scene::{Scene, SceneBody};
use super::taken::Taken;
use super::{admission, bonds, limits, overlap, preflight, strength, treatment};
use cullet_document::check::{Findings, tell};
use cullet_document::error::{SceneError, suggest};
use cullet_document::files::Files;
use cullet_document::tree::{Node, Path, join, show};
use serde::de::DeserializeOwned;
use std::collections::BTreeSet;
use std::sync::Arc;

/// Most overlapping pairs reported: the others follow from the first.
const MAX_OVERLAPS: usize = 10;

/// Longest name of a body, material, generator or group \[bytes\]: it becomes a topic of the
/// recording.
pub(super) const MAX_NAME: usize = 80;

/// What was made of a tree.
pub(super) struct Resolved {
    /// The scene; only meaningful without errors.
    pub(super) scene: Scene,
    /// What is wrong.
    pub(super) errors: Vec<SceneError>,
}

/// Makes a scene of a tree that was held against the schema. What is wrong with one value keeps
/// nothing else from being looked at.
pub(super) fn resolve(root: &Node, findings: Findings, files: &mut Files) -> Resolved {
    let mut context = ResolveContext::new(root, files);
    context.bad = findings.bad;
    let document = read_sections(&mut context);
    materials(&mut context);
    let (bodies, paths, moving) = (Vec::new(), Vec::new(), Vec::new());
    let mut builder = Builder { context, document, bodies, paths, moving };
    builder.bodies();
    builder.sheets();
    builder.names();
    limits::check(&mut builder.context, &builder.document, builder.bodies.len());
    builder.overlaps();
    let directions = builder.directions();
    builder.finish(directions)
}

fn read_sections(context: &mut ResolveContext<'_>) -> Document {
    let mut document = Document::default();
    read(context, "description", &mut document.description);
    read(context, "world", &mut document.world);
    read(context, "fracture", &mut document.fracture);
    read(context, "fidelity", &mut document.fidelity);
    context.fidelity = document.fidelity;
    read(context, "expect", &mut document.expect);
    read(context, "recording", &mut document.recording);
    read(context, "view", &mut document.view);
    document
}

/// A section as far as it is right.
fn read<T: DeserializeOwned>(context: &mut ResolveContext<'_>, key: &str, section: &mut T) {
    if let Some(node) = context.root.get(key)
        && let Some(taken) = context.take(node, &[key.into()])
    {
        *section = taken.value;
    }
}

fn materials(context: &mut ResolveContext<'_>) {
    for preset in material::presets() {
        context.materials.insert(preset.name.to_owned(), Arc::new(SceneMaterial::from(preset)));
    }
    let mut own: BTreeSet<&str> = BTreeSet::new();
    for (index, node) in context.root.items("material").iter().enumerate() {
        let path: Path = vec!["material".into(), index.into()];
        let name = node.get("name").and_then(Node::text).unwrap_or("");
        if !own.insert(name) {
            context.wrong(&join(&path, "name"), format!("a second material is called \"{name}\""));
        }
        let written = context.take::<format::Material>(node, &path);
        let whole = written.as_ref().is_some_and(|written| written.whole);
        let made = written.and_then(|written| own_material(context, &written.value, &path));
        match made.filter(|_| whole) {
            Some(made) => {
                context.materials.insert(name.to_owned(), Arc::new(made));
            }
            None => {
                context.materials.remove(name);
                context.spoiled_materials.insert(name.to_owned());
            }
        }
    }
}

/// The material that a document writes out, or the preset that it names and what it changes of it.
pub fn own_material(
    context: &mut ResolveContext<'_>,
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
                context.wrong_with(&join(path, "preset"), message, suggest(name, &known));
                return None;
            }
        },
    };
    let made = match SceneMaterial::from_written(written, base) {
        Ok(made) => made,
        Err(missing) => {
            for key in missing {
                if context.lacks(path, &[key, "preset"]) {
                    context.wrong(path, format!("`{key}` is missing: give it, or a `preset`"));
                }
            }
            return None;
        }
    };
    for (key, fault) in made.directions() {
        context.wrong(&join(&join(path, key), "normal"), fault);
    }
    for (key, fault) in written.peridynamics.as_ref().map_or_else(Vec::new, bonds::faults) {
        context.wrong(&join(&join(path, "peridynamics"), key), fault);
    }
    for (key, fault) in
        treatment::misplaced(written, made.treatment.as_ref(), made.plasticity.is_some())
    {
        context.wrong(&join(path, key), fault);
    }
    for (key, doubt) in made.doubts() {
        context.warnings.push(format!("{}: {}", show(&join(path, key)), doubt));
    }
    let faults = if made.breakable { made.faults() } else { Vec::new() };
    let sound = faults.is_empty();
    for (key, fault) in faults {
        context.wrong(&join(path, key), fault);
    }
    sound.then_some(made)
}

pub(super) struct Builder<'a> {
    pub(super) context: ResolveContext<'a>,
    pub(super) document: Document,
    pub(super) bodies: Vec<SceneBody>,
    /// Where each body was written.
    pub(super) paths: Vec<Path>,
    pub(super) moving: Vec<SceneMovingBody>,
}

impl Builder<'_> {
    fn bodies(&mut self) {
        let root = self.context.root;
        for (index, node) in root.items("body").iter().enumerate() {
            let path: Path = vec!["body".into(), index.into()];
            let Some(taken) = self.context.take::<Body>(node, &path) else {
                continue;
            };
            let body = taken.value;
            let templates = self.templates(&body, &path);
            if body.name.is_none() && self.context.lacks(&path, &["name"]) {
                self.context.wrong(&path, "`name` is missing");
            }
            if let (Some(templates), Some(name), true) = (templates, body.name, taken.whole) {
                let count = templates.len() as u64;
                if count > 1 && !self.fits(count, &join(&path, "objects")) {
                    continue;
                }
                for template in templates {
                    self.single(&template, &name, body.dynamic.as_ref(), &path);
                }
            }
        }
        self.grids();
        self.stacks();
        self.scatters();
        self.instances();
    }

    fn sheets(&mut self) {
        let root = self.context.root;
        self.context.objects = self.bodies.iter().map(|body| body.name.clone()).zip(0..).collect();
        for (index, node) in root.items("sheet").iter().enumerate() {
            let path: Path = vec!["sheet".into(), index.into()];
            if let Some(taken) = self.context.take::<SheetBody>(node, &path)
                && let Some(sheet) = self.context.sheet(&taken.value, &path)
                && taken.whole
            {
                self.moving.push(sheet);
            }
        }
        let absent = std::mem::take(&mut self.context.absent);
        let lost = self.lost(&self.bodies);
        let absent = absent.into_iter().filter(|(_, name)| !lost.covers(name)).collect();
        self.context.report_absent(absent, &self.moving);
    }

    /// Places a single body, or one of those of a mesh file of several objects.
    fn single(
        &mut self,
        template: &BodyTemplate,
        name: &str,
        dynamic: Option<&Dynamics>,
        path: &Path,
    ) {
        let own = |object: &String| format!("{name}-{}", object.trim().replace('/', "_"));
        let instance = Instance {
            name: template.object.as_ref().map_or_else(|| name.to_owned(), own),
            position: template.placement.position,
            rotation: template.placement.rotation,
            by_centroid: false,
        };
        let length = instance.name.len();
        if template.object.is_some() && length > MAX_NAME {
            let message = format!(
                "the body \"{}\" would have a name of {length} bytes; at most {MAX_NAME} are taken",
                instance.name
            );
            return self.context.wrong(&join(path, "objects"), message);
        }
        if let Some(dynamic) = dynamic {
            let placed = (instance.name.clone(), instance.pose(template));
            self.moving.extend(self.context.dynamic(dynamic, template, placed, path));
            return;
        }
        let generator = template.object.as_ref().map(|_| name);
        self.place(template, vec![instance], generator, path);
    }

    fn templates(&mut self, body: &Body, path: &Path) -> Option<Vec<BodyTemplate>> {
        let defaults = self.document.fracture.clone();
        self.context.body_templates(body, path, &defaults)
    }

    /// The one template of a generator.
    fn template(&mut self, body: &Body, path: &Path) -> Option<BodyTemplate> {
        if body.dynamic.is_some() {
            self.context.wrong(&join(path, "dynamic"), "only a single `[[body]]` can be dynamic");
        }
        let driven =
            [("keyframes", !body.keyframes.is_empty()), ("animation", body.animation.is_some())];
        for (key, _) in driven.into_iter().filter(|(_, written)| *written) {
            let message = format!("only a single `[[body]]` can be driven by `{key}`");
            self.context.wrong(&join(path, key), message);
        }
        self.templates(body, path).and_then(|mut templates| templates.pop())
    }

    fn grids(&mut self) {
        let root = self.context.root;
        for (index, node) in root.items("grid").iter().enumerate() {
            let path: Path = vec!["grid".into(), index.into()];
            let Some(Taken { value: grid, whole }) = self.context.take::<Grid>(node, &path) else {
                continue;
            };
            let template = join(&path, "body");
            self.context.template(&grid.body, &template, true);
            let fits = self.fits(generate::grid_count(&grid), &join(&path, "count"));
            let template = self.template(&grid.body, &template);
            if let Some(template) = template.filter(|_| fits && whole) {
                let instances = generate::grid(&grid, &template);
                self.place(&template, instances, Some(&grid.name), &path);
            }
        }
    }

    fn stacks(&mut self) {
        let root = self.context.root;
        for (index, node) in root.items("stack").iter().enumerate() {
            let path: Path = vec!["stack".into(), index.into()];
            let Some(Taken { value: stack, whole }) = self.context.take::<Stack>(node, &path)
            else {
                continue;
            };
            let template = join(&path, "body");
            self.context.template(&stack.body, &template, true);
            let fits = self.fits(stack.count.into(), &join(&path, "count"));
            let template = self.template(&stack.body, &template);
            if let Some(template) = template.filter(|_| fits && whole) {
                let instances = generate::stack(&stack, &template);
                self.place(&template, instances, Some(&stack.name), &path);
            }
        }
    }

    fn scatters(&mut self) {
        let root = self.context.root;
        for (index, node) in root.items("scatter").iter().enumerate() {
            let path: Path = vec!["scatter".into(), index.into()];
            let Some(Taken { value: scatter, whole }) = self.context.take::<Scatter>(node, &path)
            else {
                continue;
            };
            let template = join(&path, "body");
            self.context.template(&scatter.body, &template, false);
            let fits = self.fits(scatter.count.into(), &join(&path, "count"));
            let template = self.template(&scatter.body, &template);
            // Its places follow the seed.
            let seeded = !self.context.is_bad(&["world".into(), "seed".into()]);
            if let Some(template) = template.filter(|_| fits && whole && seeded) {
                let seed = self.document.world.seed;
                let instances = self.context.scatter(&scatter, &path, &template, seed);
                self.place(&template, instances, Some(&scatter.name), &path);
            }
        }
    }

    fn instances(&mut self) {
        let root = self.context.root;
        for (index, node) in root.items("instances").iter().enumerate() {
            let path: Path = vec!["instances".into(), index.into()];
            let Some(Taken { value, whole }) = self.context.take::<Instances>(node, &path) else {
                continue;
            };
            let template = join(&path, "body");
            self.context.template(&value.body, &template, true);
            if value.body.position != [0.0; 3] {
                let message = "bodies at given places have no position beside them";
                self.context.wrong(&join(&template, "position"), message);
            }
            let places = self.context.given_places(&value, &path);
            let template = self.template(&value.body, &template);
            let (Some(places), Some(template), true) = (places, template, whole) else { continue };
            let key = if value.file.is_some() { "file" } else { "places" };
            if self.fits(places.places.len() as u64, &join(&path, key)) {
                let before = self.context.errors.len();
                let instances = self.context.placed(&value, &places, &template, &path);
                if self.context.errors.len() == before {
                    self.place(&template, instances, Some(&value.name), &path);
                }
            }
        }
    }

    /// Whether so many more bodies are allowed.
    fn fits(&mut self, more: u64, path: &Path) -> bool {
        let most = u64::from(self.document.world.max_bodies);
        let count = more.saturating_add(self.bodies.len() as u64);
        if more == 0 {
            self.context.wrong(path, "must be at least 1 in each direction");
        } else if count > most {
            let message =
                format!("the scene would have {count} bodies; world.max_bodies is {most}");
            self.context.wrong(path, message);
        }
        more > 0 && count <= most
    }

    fn place(
        &mut self,
        template: &BodyTemplate,
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
            return self.context.wrong(path, message);
        }
        let fidelity = self.document.fidelity;
        for instance in instances {
            let pose = instance.pose(template);
            self.bodies.push(SceneBody {
                name: instance.name,
                generator: generator.map(str::to_owned),
                mesh_object: template.object.clone(),
                surface: template.geometry.surface.clone(),
                mesh_file: template.geometry.file.clone(),
                solid: Arc::clone(&template.geometry.solid),
                hulls: Arc::clone(&template.geometry.hulls),
                volume: template.geometry.mass.volume,
                inertia: template.geometry.mass.inertia,
                pose,
                velocity: template.velocity,
                spin: template.spin,
                material: Arc::clone(&template.material),
                strength: Arc::clone(&template.strength),
                weakest: strength::weakest(&template.strength),
                fixed: template.fixed,
                breakable: template.breakable,
                spacing: template.spacing.map(|h| h * fidelity.coarser_solid()),
                particles: template.particles.map(|most| fidelity.drafted_points(most)),
                impulse_threshold: template.impulse_threshold,
                solver: template.solver.clone(),
                repairs: template.geometry.repairs.clone(),
                drive: template.drive.clone(),
                group: template.group.clone(),
                direction: template.direction.clone(),
                interior: template.interior,
            });
            self.paths.push(path.clone());
        }
    }

    fn overlaps(&mut self) {
        let placed: Vec<overlap::Placed<'_>> =
            self.bodies.iter().map(|body| overlap::place(&body.hulls, &body.pose)).collect();
        let held = |body: usize| self.bodies[body].fixed || self.bodies[body].drive.is_some();
        let stopped = || self.context.files.is_stopped();
        let pairs = overlap::overlaps(&placed, MAX_OVERLAPS, stopped, |a, b| held(a) && held(b));
        for (first, second) in pairs {
            let (one, two) = (&self.bodies[first].name, &self.bodies[second].name);
            let message = format!("\"{two}\" overlaps \"{one}\" at the start");
            let help = "bodies may touch; move one of them, or make it smaller".to_owned();
            let path = self.paths[second].clone();
            self.context.unmade(&join(&path, "position"), message, Some(help));
        }
    }

    fn finish(mut self, directions: SceneDirections) -> Resolved {
        // Bodies of one generator are equal: the first speaks for all.
        let mut before = None;
        for (body, path) in self.bodies.iter().zip(&self.paths) {
            let own = body.generator.is_none() || body.mesh_object.is_some();
            let of = Some((&body.generator, path));
            let first = own || before != of;
            before = of;
            for line in body.repairs.iter().filter(|_| first) {
                self.context.warnings.push(format!("{}: {line}", body.name));
            }
            if let Some(line) =
                preflight::own_load(body, &self.document.world.gravity).filter(|_| first)
            {
                self.context.warnings.push(format!("{}: {line}", body.name));
            }
        }
        self.context.warnings.extend(self.document.fidelity.warning());
        let soft = !self.moving.is_empty();
        let found = preflight::warnings(&self.document.world, &self.bodies, soft, &directions);
        self.context.warnings.extend(found);
        let mut document = self.document;
        let budget = &mut document.fracture.max_particles;
        *budget = document.fidelity.drafted_points(*budget);
        let scene = Scene {
            name: String::new(),
            description: document.description,
            world: document.world,
            fracture: document.fracture,
            fidelity: document.fidelity,
            bodies: self.bodies,
            moving: self.moving,
            directions,
            expect: document.expect,
            recording: document.recording,
            view: document.view,
            warnings: std::mem::take(&mut self.context.warnings),
            source_text: String::new(),
            overrides: Vec::new(),
            main: String::new(),
            files: Vec::new(),
        };
        admission::check(&mut self.context, &scene, &self.paths);
        Resolved { scene, errors: self.context.errors }
    }
}
