//! Bodies that an animation of a GLB file drives.

use super::super::{Scene, load_bundle};
use animated_glb::{GlbChannel, animated_glb};
use cullet_document::files::{Bundle, SceneFile};
use cullet_geometry::{Pose, Quat, Vec3};
use std::f64::consts::FRAC_PI_2;
use std::sync::Arc;

#[path = "../../../../tests/common/animated_glb.rs"]
pub(crate) mod animated_glb;

/// The box of the file: from the shoulder along the file's x, higher (y) than deep (z) \[m\].
const BOX: ([f32; 3], [f32; 3]) = ([0.0, -0.125, -0.0625], [1.0, 0.125, 0.0625]);

/// An arm at (2, 1, 0) of the file that turns by 90° about the file's y, which is up, while its
/// stand rises by 1 m; a second later a still hand is at the end of it.
fn file() -> Vec<u8> {
    let nodes = [
        r#""name":"stand","children":[1],"translation":[2,0,0]"#,
        r#""name":"arm","children":[2],"translation":[0,1,0],"mesh":0"#,
        r#""name":"hand","translation":[1,0,0],"scale":[0.5,0.5,0.5]"#,
    ];
    let half = std::f32::consts::FRAC_1_SQRT_2;
    let channel = |node, path, values: &[f32]| GlbChannel {
        animation: 0,
        node,
        path,
        curve: "LINEAR",
        times: vec![0.0, 1.0],
        values: values.to_vec(),
    };
    let channels = [
        channel(0, "translation", &[2.0, 0.0, 0.0, 2.0, 1.0, 0.0]),
        channel(1, "rotation", &[0.0, 0.0, 0.0, 1.0, 0.0, half, 0.0, half]),
    ];
    animated_glb(&nodes, BOX, &["Swing"], &channels, "")
}

fn scene(body: &str, overrides: &[&str]) -> Result<Scene, String> {
    let text = format!("[[body]]\nname = \"arm\"\nmaterial = \"steel\"\n{body}\n");
    let file = |key: &str, bytes: Vec<u8>| SceneFile {
        key: format!("scene/{key}"),
        bytes: Arc::new(bytes),
    };
    let files = vec![
        file("scene.toml", text.into_bytes()),
        file("props/arm.glb", self::file()),
        file("arm.obj", b"v 0 0 0\n".to_vec()),
        file("bad.glb", self::file()[..100].to_vec()),
    ];
    let (name, main) = ("test".to_owned(), "scene/scene.toml".to_owned());
    let overrides = overrides.iter().map(|&text| text.to_owned()).collect();
    load_bundle(&Bundle { name, main, overrides, files }).map_err(|errors| errors.to_string())
}

/// Where a body is at a time.
fn pose(scene: &Scene, time: f64) -> Pose {
    scene.bodies[0].drive.as_ref().expect("it is driven").at(time)
}

/// Corners of the box around a body at a time \[m\].
fn bounds(scene: &Scene, time: f64) -> (Vec3, Vec3) {
    scene.bodies[0].solid.transformed(&pose(scene, time)).mesh.bounds().expect("has corners")
}

fn near((a, b): (Vec3, Vec3), low: [f64; 3], high: [f64; 3]) {
    let off = (a - Vec3::from(low)).norm() + (b - Vec3::from(high)).norm();
    // The corners are f32.
    assert!(off < 1e-6, "{a} {b}, not {low:?} to {high:?}");
}

/// The file has y up and looks along -z, so its x stays, its y becomes z, and its z becomes -y.
#[test]
fn a_mesh_moves_as_it_does_in_its_file() {
    let arm = "mesh = \"props/arm.glb\"\nanimation = { file = \"props/arm.glb\", node = \"arm\" }";
    let plain = scene(arm, &[]).expect("loads");
    near(bounds(&plain, 0.0), [2.0, -0.0625, 0.875], [3.0, 0.0625, 1.125]);
    // From x the file's turn about y leads to -z, which is y here.
    near(bounds(&plain, 1.0), [1.9375, 0.0, 1.875], [2.0625, 1.0, 2.125]);
    assert_eq!(bounds(&plain, 5.0), bounds(&plain, 1.0));
    let off = plain.bodies[0].pose.translation.vector - pose(&plain, 0.0).translation.vector;
    assert!(off.norm() < 1e-12, "{off}");
    // Half way the far end is on its circle, not on the chord.
    let half = pose(&plain, 0.5);
    let end = half * (plain.bodies[0].pose.inverse() * nalgebra::Point3::new(3.0, 0.0, 1.0));
    let wanted = Vec3::new(2.0 + FRAC_PI_2.sin() * 0.5_f64.sqrt(), 0.5_f64.sqrt(), 1.5);
    assert!((end.coords - wanted).norm() < 1e-6, "{end}");
    // The scene's place, scale and start hold for all of it.
    let moved = scene(
        "mesh = \"props/arm.glb\"\nscale = 2\nposition = [0, 0, 7]\n\
         rotation = { axis = [0, 0, 1], degrees = 90 }\n\
         animation = { file = \"props/arm.glb\", name = \"Swing\", node = \"arm\", start = 3 }",
        &[],
    )
    .expect("loads");
    near(bounds(&moved, 3.0), [-0.125, 4.0, 8.75], [0.125, 6.0, 9.25]);
    near(bounds(&moved, 4.0), [-2.0, 3.875, 10.75], [0.0, 4.125, 11.25]);
    // Whichever point of it is placed, it moves as it does in the file.
    let based = scene(&format!("{arm}\nanchor = \"base\"\nposition = [10, 0, 0]"), &[]);
    let based = based.expect("loads");
    near(bounds(&based, 0.0), [9.5, -0.0625, 0.0], [10.5, 0.0625, 0.25]);
    near(bounds(&based, 1.0), [9.4375, 0.0, 1.0], [9.5625, 1.0, 1.25]);
}

#[test]
fn any_other_body_is_at_the_node() {
    let shape = "shape = { kind = \"box\", size = [0.2, 0.4, 0.6] }\n";
    let animation = "file = \"props/arm.glb\", node = \"arm\"";
    let plain = scene(&format!("{shape}animation = {{ {animation} }}"), &[]).expect("loads");
    near(bounds(&plain, 0.0), [1.9, -0.2, 0.7], [2.1, 0.2, 1.3]);
    near(bounds(&plain, 1.0), [1.8, -0.1, 1.7], [2.2, 0.1, 2.3]);
    let turn = pose(&plain, 1.0).rotation;
    assert!(turn.angle_to(&Quat::from_axis_angle(&Vec3::z_axis(), FRAC_PI_2)) < 1e-6, "{turn}");
    let turned = format!(
        "{shape}anchor = \"base\"\nposition = [0, 0, 5]\n\
         animation = {{ {animation}, up = \"z\", scale = 0.5 }}"
    );
    // With z up in the file its arm is at (2, 1, 0) here and rises along y.
    let turned = scene(&turned, &[]).expect("loads");
    near(bounds(&turned, 0.0), [0.9, 0.3, 5.0], [1.1, 0.7, 5.6]);
    near(bounds(&turned, 1.0), [1.0, 0.8, 4.9], [1.6, 1.2, 5.1]);
    // The file travels with the scene, and the scene is the same from what travelled.
    assert!(plain.files.iter().any(|file| file.key == "scene/props/arm.glb"));
    let bundle = plain.bundle();
    let again = load_bundle(&bundle).expect("loads");
    assert_eq!(again.bodies[0].drive, plain.bodies[0].drive);
}

#[test]
fn what_is_wrong_with_an_animation_is_said_with_its_place() {
    let shape = "shape = { kind = \"box\", size = [0.2, 0.4, 0.6] }\n";
    let good = "file = \"props/arm.glb\", node = \"arm\"";
    let place = "body.arm.animation";
    for (keys, words) in [
        ("file = \"arm.glb\", node = \"arm\"".to_owned(), [".file", "arm.glb"]),
        ("file = \"arm.obj\", node = \"arm\"".to_owned(), [".file", "no glTF file"]),
        ("file = \"bad.glb\", node = \"arm\"".to_owned(), [".file", "the file ends early"]),
        ("node = \"arm\"".to_owned(), ["", "`file` is missing"]),
        ("file = \"props/arm.glb\", node = \"am\"".to_owned(), [".node", "\"hand\""]),
        ("file = \"props/arm.glb\", node = \"am\"".to_owned(), ["", "did you mean \"arm\"?"]),
        (format!("{good}, name = \"Swim\""), [".name", "the file has \"Swing\""]),
        (format!("{good}, start = 700"), [".start", "must be at most 600 s"]),
        (format!("{good}, scale = 0"), [".scale", "above 0"]),
        (format!("{good}, scale = 90000"), ["", "from the origin at 0 s; at most 100000 m"]),
        (format!("{good}, scale = 20000"), ["", "m/s at 0 s; at most 10000 m/s"]),
        (
            "file = \"props/arm.glb\", node = \"hand\"".to_owned(),
            [".node", "is scaled by (0.5, 0.5, 0.5)"],
        ),
    ] {
        let said = scene(&format!("{shape}animation = {{ {keys} }}"), &[]).expect_err("wrong");
        let path = format!("{place}{}", words[0]);
        assert!(said.contains(&path) && said.contains(words[1]), "{words:?} not in:\n{said}");
    }
    for (more, words) in [
        ("keyframes = [{ at = 0 }]", ["body.arm.animation", "not both"]),
        ("interpolation = \"smooth\"", ["body.arm.interpolation", "with `keyframes`"]),
        ("velocity = [1, 0, 0]", ["body.arm.velocity", "its animation says how it moves"]),
        ("fixed = true", ["body.arm.fixed", "fixed or driven"]),
        ("breakable = true", ["body.arm.breakable", "does not break"]),
    ] {
        let said = scene(&format!("{shape}{more}\nanimation = {{ {good} }}"), &[]);
        let said = said.expect_err("wrong");
        assert!(words.iter().all(|word| said.contains(word)), "{words:?} not in:\n{said}");
    }
    let own = format!("mesh = \"props/arm.glb\"\nanimation = {{ {good}, scale = 2 }}");
    let said = scene(&own, &[]).expect_err("wrong");
    assert!(said.contains("body.arm.animation.scale") && said.contains("same file"), "{said}");
    let stack = format!(
        "{shape}[[stack]]\nname = \"s\"\ncount = 2\noffset = [0, 0, 2]\n[stack.body]\n\
         material = \"steel\"\n{shape}position = [0, 9, 9]\nanimation = {{ {good} }}"
    );
    let said = scene(&stack, &[]).expect_err("wrong");
    assert!(said.contains("stack.s.body.animation: only a single"), "{said}");
    // An override sets it in place of keyframes.
    let keyed = format!("{shape}keyframes = [{{ at = 0 }}]");
    let set = "body.arm.animation={ file = \"scene/props/arm.glb\", node = \"arm\" }".to_owned();
    let said = scene(&keyed, &[&set]).expect_err("given files are not bundled");
    assert!(said.contains("given/scene/props/arm.glb"), "{said}");
}
