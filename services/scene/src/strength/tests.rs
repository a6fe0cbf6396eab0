use super::weakest;
use crate::{Scene, load_bundle, presets};
use cullet_document::SceneErrors;
use cullet_document::files::{Bundle, SceneFile};
use cullet_geometry::Vec3;
use cullet_model::StrengthField;
use cullet_model::strength::Region;
use std::sync::Arc;

const SCENE: &str = r#"
[[material]]
name = "slate"
preset = "granite"
weibull = 9
correlation = "12 mm"
weak_plane = { normal = [0, 0, 2], ratio = 0.25 }
layers = { normal = [0, 3, 4], thickness = "5 mm", ratio = "60 %", jitter = 0.3 }

[[body]]
name = "slab"
material = "slate"
shape = { kind = "cone", radius = 0.1, height = 0.4 }
paint = [
  { kind = "sphere", centre = [0, 0, "10 cm"], radius = "2 cm", factor = 0.5, edge = "1 mm" },
  { kind = "box", min = [0, 0, 0], max = [1, 1, 1], factor = 2 },
  { kind = "half-space", point = [0, 0, 0], normal = [0, 0, 5], factor = 0.5 },
  { kind = "cylinder", from = [0, 0, 0], to = [0, 0, 1], radius = 0.1, factor = 3 },
]
"#;

const MESH: &str = r#"
[[body]]
name = "slab"
material = "soda-lime-glass"
mesh = "t.obj"
scale = 0.1
up = "y"
paint = [{ kind = "corners", reach = "3 cm", none = 1, full = 0.2 }]
"#;

const COLOURED: &str = "v 0 0 0 1 0 0\nv 1 0 0 0 0 0\nv 0 1 0 0 0 1\nv 0 0 1 0.5 0 0\n\
                        f 1 3 2\nf 1 2 4\nf 2 3 4\nf 3 1 4\n";

fn load(text: &str, overrides: &[&str], files: &[(&str, &str)]) -> Result<Scene, SceneErrors> {
    let own = [("scene/scene.toml", text)];
    let file = |(key, text): &(&str, &str)| SceneFile {
        key: (*key).to_owned(),
        bytes: Arc::new(text.as_bytes().to_vec()),
    };
    load_bundle(&Bundle {
        name: "test".to_owned(),
        main: "scene/scene.toml".to_owned(),
        overrides: overrides.iter().map(|&text| text.to_owned()).collect(),
        files: own.iter().chain(files).map(file).collect(),
    })
}

fn strength(text: &str, overrides: &[&str], files: &[(&str, &str)]) -> Arc<StrengthField> {
    let scene = load(text, overrides, files).unwrap_or_else(|errors| panic!("{errors}"));
    Arc::clone(&scene.bodies[0].strength)
}

fn errors(text: &str, overrides: &[&str], files: &[(&str, &str)]) -> String {
    load(text, overrides, files).expect_err("must not load").to_string()
}

#[test]
fn a_scene_says_how_strength_varies() {
    let field = strength(SCENE, &[], &[]);
    assert_eq!((field.weibull, field.correlation), (9.0, Some(0.012)));
    let weak = field.weak_plane.expect("a weak plane");
    assert_eq!((weak.normal, weak.ratio), (Vec3::z(), 0.25));
    let layers = field.layers.expect("layers");
    assert!((Vec3::from(layers.normal) - Vec3::new(0.0, 0.6, 0.8)).norm() < 1e-15);
    assert_eq!((layers.thickness, layers.ratio, layers.jitter), (0.005, 0.6, 0.3));
    assert_eq!(field.strokes.len(), 4);
    assert_eq!(
        field.strokes[0].region,
        Region::Sphere { centre: Vec3::new(0.0, 0.0, 0.1), radius: 0.02 }
    );
    assert_eq!(
        field.strokes[2].region,
        Region::HalfSpace { point: Vec3::zeros(), normal: Vec3::z() }
    );
    // A cone's centroid is a quarter of its height above its base, a quarter below its origin.
    assert!((Vec3::from(field.offset) - Vec3::new(0.0, 0.0, -0.1)).norm() < 1e-12);
    assert!((weakest(&field) - 0.5 * 0.5 * 0.6 * 0.25).abs() < 1e-12);
    assert_eq!(strength(SCENE, &["body.slab.material=ice"], &[]).weibull, 5.0);
}

#[test]
fn corners_are_painted_by_colour_or_by_a_file() {
    let files = [("scene/t.obj", COLOURED)];
    let paint = strength(MESH, &[], &files).vertices.clone().expect("paint");
    let near = |found: &[f64], wanted: [f64; 4]| {
        found.len() == 4 && found.iter().zip(wanted).all(|(a, b)| (a - b).abs() < 1e-12)
    };
    assert!(near(&paint.factors, [0.2, 1.0, 1.0, 0.6]), "{:?}", paint.factors);
    assert_eq!(paint.reach, 0.03);
    // The file's y is up: the third corner stands above the first.
    assert!((paint.points[2] - Vec3::new(0.0, 0.0, 0.1)).norm() < 1e-12, "{}", paint.points[2]);
    let blue = strength(MESH, &["body.slab.paint[0].channel=blue"], &files);
    assert!(near(&blue.vertices.as_ref().expect("paint").factors, [1.0, 1.0, 0.2, 1.0]));
    let own = [files[0], ("given/f.txt", "0.3\n1\n\n2\n0.5\n")];
    let named = strength(MESH, &["body.slab.paint[0].file=f.txt"], &own);
    assert_eq!(named.vertices.as_ref().expect("paint").factors, [0.3, 1.0, 2.0, 0.5]);
    let scene = load(MESH, &[], &files).expect("loads");
    assert!((scene.bodies[0].weakest - 0.2).abs() < 1e-12);
    let again = load_bundle(&scene.bundle()).expect("a bundle has the files of its paint");
    assert_eq!(again.bodies[0].strength, scene.bodies[0].strength);
}

#[test]
fn bad_strength_is_refused_with_place_and_bound() {
    let cases = [
        ("material.slate.weibull=0.5", "weibull: must be at least 1; it is 0.5"),
        ("material.slate.correlation=0", "must be above 0 m; it is 0 m"),
        ("material.slate.weak_plane={normal=[0,0,0],ratio=0.5}", "must have a length above 1e-6"),
        ("material.slate.weak_plane.ratio=2", "must be at most 1; it is 2"),
        ("material.slate.layers.thickness=-1", "must be above 0 m; it is -1 m"),
        ("material.slate.layers.jitter=1", "must be at most 0.9; it is 1"),
        ("body.slab.paint[0].factor=0", "must be at least 0.01; it is 0"),
        ("body.slab.paint[1].max=[1,1,0]", "0 m is not above 0 m"),
        ("body.slab.paint[2].normal=[0,0,0]", "must have a length above 1e-6"),
        ("body.slab.paint[3].to=[0,0,0]", "must differ from `from`"),
        ("body.slab.paint[3].kind=tube", "is not one of box, sphere, half-space"),
        ("body.slab.paint=[{kind=\"corners\",reach=1}]", "only a `mesh` has corners to paint"),
    ];
    for (set, words) in cases {
        let said = errors(SCENE, &[set], &[]);
        assert!(said.contains(words), "{set} gave:\n{said}");
    }
    let plain = [(
        "scene/t.obj",
        "v 0 0 0\nv 1 0 0\nv 0 1 0\nv 0 0 1\nf 1 3 2\nf 1 2 4\nf 2 3 4\nf 3 1 4\n",
    )];
    let said = errors(MESH, &[], &plain);
    assert!(said.contains("t.obj has no colours: name a `file` of factors"), "{said}");
    for (text, words) in [
        ("1\n2\n", "has 2 factors; the mesh file has 4 corners"),
        ("1\n2\nx\n1\n", "line 3 must be a number in [0.01, 100]; it is \"x\""),
        ("1\n2\n1\n0.001\n", "line 4 must be a number in [0.01, 100]; it is \"0.001\""),
    ] {
        let files = [plain[0], ("given/f.txt", text)];
        let said = errors(MESH, &["body.slab.paint[0].file=f.txt"], &files);
        assert!(said.contains(words), "{said}");
    }
}

#[test]
fn every_preset_has_a_modulus_with_its_source() {
    for preset in presets() {
        assert!((1.0..=1000.0).contains(&preset.weibull.value), "{}", preset.name);
        assert!(preset.weibull.source.len() > 20, "{}", preset.name);
    }
}

const SCORED: &str = r#"
[[body]]
name = "pane"
material = "soda-lime-glass"
shape = { kind = "box", size = [0.4, 0.3, 0.006] }
paint = [{ kind = "line", points = [[-0.2, 0, 0.003], [0.2, 0, 0.003]], factor = 0.1 }]
"#;

/// Through the wall without a depth, and along a surface that is round.
#[test]
fn a_scored_line_follows_the_surface() {
    let field = strength(SCORED, &[], &[]);
    let mut along = 0.0;
    for stroke in &field.strokes {
        let Region::Groove { from, to, inward, half_width } = stroke.region else {
            panic!("{stroke:?}")
        };
        assert!((inward - Vec3::new(0.0, 0.0, -0.006)).norm() < 1e-6, "{inward}");
        assert_eq!((half_width, stroke.factor), (0.0, 0.1));
        along += (to - from).norm();
    }
    assert!((along - 0.4).abs() < 1e-12, "{along}");
    assert!((weakest(&field) - 0.1).abs() < 1e-12, "one line, of {} grooves", field.strokes.len());
    // From edge to edge whichever way, and along an edge: never along the pane.
    for points in ["[[-0.2,-0.15,0.003],[-0.2,0.15,0.003]]", "[[0,-0.15,0.003],[0,0.15,0.003]]"] {
        let set = format!("body.pane.paint[0].points={points}");
        let field = strength(SCORED, &[&set], &[]);
        assert!(!field.strokes.is_empty());
        for stroke in &field.strokes {
            let Region::Groove { inward, .. } = stroke.region else { panic!("{stroke:?}") };
            assert!((inward.norm() - 0.006).abs() < 1e-6, "{inward}");
        }
    }
    // Between points that are 90 degrees of a cylinder apart it lies on the cylinder.
    let round = [
        "body.pane.shape={kind=\"cylinder\", radius=0.1, height=0.4, segments=256}",
        "body.pane.paint=[{kind=\"line\", points=[[0.1,0,0],[0,0.1,0]], factor=0.2, depth=0.01, \
         width=0.004}]",
    ];
    let field = strength(SCORED, &round, &[]);
    assert!(field.strokes.len() > 5, "{}", field.strokes.len());
    for stroke in &field.strokes {
        let Region::Groove { from, to, inward, half_width } = stroke.region else {
            panic!("{stroke:?}")
        };
        assert_eq!(half_width, 0.002);
        let depth = inward.norm();
        assert!((depth - 0.01).abs() < 1e-12 && inward.dot(&from) < 0.0, "{inward} at {from}");
        for end in [from, to] {
            assert!((end.xy().norm() - 0.1).abs() < 1e-4, "{end} is off the surface");
        }
    }
    for (set, words) in [
        ("body.pane.paint[0].points=[[0,0,0.003]]", "two points or more; it has 1"),
        (
            "body.pane.paint[0].points=[[0,0,0.003],[0,0,0.003]]",
            "must differ from the point before",
        ),
        ("body.pane.paint[0].points=[[0,0,0.003],[0.1,0,0.2]]", "off the surface; at most"),
        ("body.pane.paint[0].depth=0", "must be above 0 m; it is 0 m"),
    ] {
        let said = errors(SCORED, &[set], &[]);
        assert!(said.contains(words), "{set} gave:\n{said}");
    }
}

/// What stays whole is as strong as paint can make it.
#[test]
fn parts_that_stay_whole_are_strong() {
    let whole = "body.pane.pieces.whole=[{centre=[0.1,0,0], radius=0.02}]";
    let field = strength(SCORED, &[whole], &[]);
    let last = field.strokes.last().expect("a region");
    let region = Region::Sphere { centre: Vec3::new(0.1, 0.0, 0.0), radius: 0.02 };
    assert_eq!((last.region, last.factor), (region, 100.0));
}

/// Too many regions in all are told where they are: parts that stay whole are strokes too.
#[test]
fn too_many_parts_that_stay_whole_are_told_at_these() {
    let ball = "{ centre = [0, 0, 0.2], radius = 0.01 }, ".repeat(60);
    let part = "{ kind = \"sphere\", centre = [0, 0, 0.2], radius = 0.02, factor = 0.5 }, ";
    let scene = |painted: usize| {
        let paint = part.repeat(painted);
        let shape = "shape = { kind = \"cone\", radius = 0.1, height = 0.4 }";
        let paint = format!("material = \"granite\"\n{shape}\npaint = [{paint}]");
        format!("[[body]]\nname = \"slab\"\n{paint}\npieces = {{ whole = [{ball}] }}\n")
    };
    assert_eq!(strength(&scene(196), &[], &[]).strokes.len(), 256);
    let why = load(&scene(200), &[], &[]).expect_err("too many").to_string();
    let told = "at most 56 beside 200 painted regions and pieces of lines; it has 60";
    assert!(why.contains(told) && why.contains("pieces.whole"), "{why}");
}
