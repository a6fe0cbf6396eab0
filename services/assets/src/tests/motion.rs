//! Animations of GLB files: poses are those of the file, and what no body does is refused.

use super::super::{MotionFileError, NodeMotion, node_motion};
use animated_glb::{GlbChannel, animated_glb, packed};
use nalgebra::{Matrix4, Rotation3, Translation3, Vector3};

#[path = "../../../../tests/common/animated_glb.rs"]
pub(super) mod animated_glb;

/// A crane: a base that turns and rises, an arm of twice the size on it that is shifted, a hook.
const NODES: [&str; 3] = [
    r#""name":"base","children":[1],"translation":[1,0,0],"scale":[2,2,2]"#,
    r#""name":"arm","children":[2],"rotation":[0,0,0.6,0.8],"mesh":0"#,
    r#""name":"hook","translation":[0,3,0],"scale":[1,2,1],"mesh":0"#,
];

fn motion_of(
    bytes: &[u8],
    animation: Option<&str>,
    node: &str,
) -> Result<NodeMotion, MotionFileError> {
    node_motion(bytes, &mut |_| None, animation, node)
}

fn channel(
    node: usize,
    path: &'static str,
    curve: &'static str,
    times: &[f32],
    values: &[f32],
) -> GlbChannel {
    let (times, values) = (times.to_vec(), values.to_vec());
    GlbChannel { animation: 0, node, path, curve, times, values }
}

/// The quaternion of a turn about y \[rad\], as f32.
fn about_y(angle: f64) -> [f32; 4] {
    [0.0, (angle / 2.0).sin() as f32, 0.0, (angle / 2.0).cos() as f32]
}

/// The angle that a quaternion about y, as f32, really has \[rad\].
fn angle_of(q: [f32; 4]) -> f64 {
    2.0 * f64::from(q[1]).atan2(f64::from(q[3]))
}

fn channels() -> Vec<GlbChannel> {
    let turns = [about_y(0.3), about_y(2.3)].concat();
    vec![
        channel(0, "rotation", "LINEAR", &[0.0, 1.0], &turns),
        channel(0, "translation", "LINEAR", &[0.5, 1.5], &[1.0, 0.0, 0.0, 1.0, 4.0, 0.0]),
        // One of t² between 0 and 2, along x.
        channel(
            2,
            "translation",
            "CUBICSPLINE",
            &[0.0, 2.0],
            &[0., 0., 0., 0., 3., 0., 0., 0., 0., 4., 0., 0., 4., 3., 0., 0., 0., 0.],
        ),
        channel(2, "scale", "CUBICSPLINE", &[0.0], &[9., 9., 9., 1., 2., 1., 9., 9., 9.]),
    ]
}

fn file(channels: &[GlbChannel], more: &str) -> Vec<u8> {
    animated_glb(&NODES, ([-0.5; 3], [0.5; 3]), &["Swing", "Idle"], channels, more)
}

fn motion(node: &str) -> NodeMotion {
    motion_of(&file(&channels(), ""), Some("Swing"), node).unwrap_or_else(|why| panic!("{why}"))
}

/// The poses worked out with matrices, from the numbers that the file has.
#[test]
fn poses_are_those_of_the_file() {
    let (from, to) = (angle_of(about_y(0.3)), angle_of(about_y(2.3)));
    let spin = |angle: f64| Rotation3::from_axis_angle(&Vector3::y_axis(), angle).to_homogeneous();
    let moved = |x: f64, y: f64| Translation3::new(x, y, 0.0).to_homogeneous();
    let arm_turn = 2.0 * f64::from(0.6_f32).atan2(f64::from(0.8_f32));
    let arm = Rotation3::from_axis_angle(&Vector3::z_axis(), arm_turn).to_homogeneous();
    for step in 0..=25 {
        let time = f64::from(step) * 0.1;
        let share = time.min(1.0);
        let height = 4.0 * (time - 0.5).clamp(0.0, 1.0);
        let base =
            moved(1.0, height) * spin(from + (to - from) * share) * Matrix4::new_scaling(2.0);
        let along = time.min(2.0).powi(2);
        let wanted =
            [("base", base), ("arm", base * arm), ("hook", base * arm * moved(along, 3.0))];
        for (node, wanted) in wanted {
            let got = motion(node).motion.at(time);
            let off = (got.translation.vector - wanted.column(3).xyz()).norm();
            assert!(off < 1e-9, "{node} is {off} m off at {time} s");
            let turn = got.rotation.to_homogeneous() * 2.0;
            let off = (turn - wanted).fixed_view::<3, 3>(0, 0).amax();
            assert!(off < 1e-9, "the turn of {node} is {off} off at {time} s");
        }
    }
    assert_eq!(motion("hook").scale, [1.0, 2.0, 1.0]);
    assert_eq!(motion("hook").motion.times(), [0.0, 0.5, 1.0, 1.5, 2.0]);
    let rest = motion("hook").motion.rest;
    let wanted =
        (moved(1.0, 0.0) * Matrix4::new_scaling(2.0) * arm * moved(0.0, 3.0)).column(3).xyz();
    assert!((rest.translation.vector - wanted).norm() < 1e-9, "{rest}");
}

#[test]
fn a_step_that_changes_nothing_is_taken_and_any_other_is_not() {
    let step = |values: &[f32]| {
        let moved = channel(2, "translation", "STEP", &[0.0, 1.0], values);
        motion_of(&file(&[moved], ""), Some("Swing"), "hook")
    };
    let still = step(&[0.0, 3.0, 0.0, 0.0, 3.0, 0.0]).expect("it stands still");
    assert_eq!(still.motion.at(0.5), still.motion.rest);
    let said = step(&[0.0, 3.0, 0.0, 0.0, 4.0, 0.0]).expect_err("it jumps").to_string();
    assert!(said.contains("\"hook\" jumps (its interpolation is STEP)"), "{said}");
}

fn refusal(channels: &[GlbChannel], more: &str, name: Option<&str>, node: &str) -> String {
    motion_of(&file(channels, more), name, node).expect_err("it is refused").to_string()
}

#[test]
fn what_there_is_none_of_is_said_with_what_there_is() {
    let all = channels();
    let said = refusal(&all, "", Some("Swin"), "arm");
    assert_eq!(said, "there is no animation \"Swin\"; the file has \"Swing\", \"Idle\"");
    let said = refusal(&all, "", None, "arm");
    assert_eq!(said, "`name` is missing: the file has \"Swing\", \"Idle\"");
    let said = refusal(&all, "", Some("Swing"), "crane");
    assert_eq!(said, "there is no node \"crane\"; the file has \"base\", \"arm\", \"hook\"");
    let hook: Vec<GlbChannel> = all.iter().filter(|it| it.node == 2).cloned().collect();
    let said = refusal(&hook, "", Some("Swing"), "arm");
    let wanted = "moves neither \"arm\" nor a node that it hangs on; it moves \"hook\"";
    assert!(said.contains(wanted), "{said}");
    let none = animated_glb(&NODES, ([0.0; 3], [1.0; 3]), &[], &[], "");
    let said = motion_of(&none, None, "arm").expect_err("none").to_string();
    assert_eq!(said, "the file has no animations");
    let twins = [r#""name":"a","children":[1]"#, r#""name":"a""#];
    let twins = animated_glb(&twins, ([0.0; 3], [1.0; 3]), &["Swing"], &[], "");
    let said = motion_of(&twins, None, "a").expect_err("two").to_string();
    assert_eq!(said, "2 nodes are called \"a\"; a name must be that of one");
    assert!(matches!(motion_of(b"glTF", None, "a"), Err(MotionFileError::File(_))));
}

#[test]
fn what_no_rigid_body_does_is_refused() {
    let with = |added: GlbChannel| [channels(), vec![added]].concat();
    let (name, scale) = (Some("Swing"), [1.0, 1.0, 1.0, 1.0, 3.0, 1.0]);
    let grown = with(channel(0, "scale", "LINEAR", &[0.0, 1.0], &scale));
    assert!(refusal(&grown, "", name, "hook").contains("\"base\" is scaled by the animation"));
    let weights = with(channel(2, "weights", "LINEAR", &[0.0], &[0.5]));
    assert!(refusal(&weights, "", name, "hook").contains("\"hook\" has shape keys"));
    assert!(motion_of(&file(&weights, ""), name, "arm").is_ok(), "what hangs on it has them");
    let turns = [[0.0, 0.0, 0.0, 1.0], [0.0, 2.0, 0.0, 0.0]].concat();
    let long = with(channel(1, "rotation", "LINEAR", &[0.0, 1.0], &turns));
    let said = refusal(&long, "", name, "arm");
    let wanted = "rotation of the node \"arm\": key 1 has a quaternion of norm 2";
    assert!(said.contains(wanted), "{said}");
    let back = with(channel(1, "translation", "LINEAR", &[1.0, 0.5], &[0.0; 6]));
    let said = refusal(&back, "", name, "arm");
    assert!(said.contains("key 1 is at 0.5 s; it must be later than the one before"), "{said}");
    let few = with(channel(1, "translation", "LINEAR", &[0.0, 0.5, 1.0], &[0.0; 6]));
    let said = refusal(&few, "", name, "arm");
    assert!(said.contains("there are 3 times, but 2 values"), "{said}");
    // A bone moves as any node; a mesh that bones deform does not.
    let mut nodes = NODES;
    nodes[2] = r#""name":"hook","mesh":0,"skin":0"#;
    let skin = r#""skins":[{"joints":[1]}]"#;
    let file = animated_glb(&nodes, ([0.0; 3], [1.0; 3]), &["Swing"], &channels()[..2], skin);
    assert!(motion_of(&file, name, "arm").is_ok(), "the bone");
    let said = motion_of(&file, name, "hook").expect_err("the mesh").to_string();
    assert!(said.contains("\"hook\" is deformed by bones"), "{said}");
    // What hangs on an uneven scale is sheared; the node itself may have one.
    nodes[1] = r#""name":"arm","children":[2],"scale":[1,3,1],"mesh":0"#;
    let file = animated_glb(&nodes, ([0.0; 3], [1.0; 3]), &["Swing"], &channels()[..2], skin);
    assert!(motion_of(&file, name, "arm").is_ok());
    nodes[2] = r#""name":"hook","mesh":0"#;
    let file = animated_glb(&nodes, ([0.0; 3], [1.0; 3]), &["Swing"], &channels()[..2], "");
    let said = motion_of(&file, name, "hook").expect_err("sheared").to_string();
    assert!(said.contains("\"arm\" is scaled unevenly"), "{said}");
}

/// A count that no bytes stand behind costs no memory.
#[test]
fn counts_of_sparse_accessors_are_bounded() {
    let whole = file(&channels()[1..2], "");
    let length = u32::from_le_bytes(whole[12..16].try_into().expect("four")) as usize;
    let json = std::str::from_utf8(&whole[20..20 + length]).expect("text");
    let with = |view: usize, count: usize, named: u64| {
        let from = format!("\"bufferView\":{view},\"componentType\":5126,\"count\":{count},");
        let to = format!(
            "\"sparse\":{{\"count\":1,\"indices\":{{\"bufferView\":1,\"componentType\":5125}},\
             \"values\":{{\"bufferView\":2}}}},\"componentType\":5126,\"count\":{named},"
        );
        assert!(json.contains(&from), "{json}");
        packed(json.replace(&from, &to), whole[28 + length..].to_vec())
    };
    let said =
        |bytes: &[u8]| motion_of(bytes, Some("Swing"), "base").expect_err("too many").to_string();
    assert!(said(&with(1, 2, 1_000_000)).contains("have 1000000 keys; at most 100000 are read"));
    let values = said(&with(2, 2, 1_000_000));
    assert!(values.contains("there are 2 times, but 1000000 values"), "{values}");
    let most = "name 1000000000000 values; at most 12000000 are read";
    assert!(said(&with(1, 2, 1_000_000_000_000)).contains(most));
    let corners = super::super::read("a.glb", &with(0, 36, 1_000_000_000_000));
    assert!(corners.expect_err("too many").to_string().contains(most));
}

#[test]
fn a_scale_that_swings_between_its_keys_is_refused() {
    let scale = |slope: f32| {
        let key = [[slope; 3], [2.0; 3], [slope; 3]].concat();
        let swings = channel(0, "scale", "CUBICSPLINE", &[0.0, 1.0], &[&key[..], &key].concat());
        let all = [channels(), vec![swings]].concat();
        motion_of(&file(&all, ""), Some("Swing"), "base")
    };
    assert!(scale(1e-6).is_ok());
    let said = scale(1.0).expect_err("it swings").to_string();
    assert!(said.contains("\"base\" is scaled by the animation"), "{said}");
}

#[test]
fn no_bytes_make_the_reader_panic() {
    let whole = file(&channels(), "");
    for length in (0..whole.len()).step_by(7) {
        assert!(motion_of(&whole[..length], Some("Swing"), "hook").is_err(), "{length} bytes");
    }
    for place in (0..whole.len()).step_by(3) {
        let mut bytes = whole.clone();
        bytes[place] ^= 0x15;
        // Whatever it says, it says it.
        let _ = motion_of(&bytes, Some("Swing"), "hook");
    }
}
