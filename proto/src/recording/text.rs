//! The messages of a recording as a `.proto` file, for programs that read recordings without this
//! code: `proto/recording.proto`.

use super::messages::declarations;
use super::schema::{Comment, EnumDeclaration, MessageDeclaration, PACKAGE};
use super::sheets;
use foxglove::prost_types::FieldDescriptorProto;
use foxglove::prost_types::field_descriptor_proto::{Label, Type};

const BEGINNING: &str = "\
// The messages of Cullet's own in a recording. docs/recording.md says which topic has which of
// them. Units are SI and stand in brackets, [1] for ratios; a column of triples has three entries a
// row, one after another. Numbers of fields are never reused; later versions only add fields.
//
// Written by `cullet schema --recording` from proto/src/recording: change it there.
";

/// The `.proto` file of every message of ours: what [`super::sheet_schema_bytes`] describes, with
/// the comments of the declarations.
#[must_use]
pub fn schema_text() -> String {
    let (all, of_sheets) = (declarations(), sheets::declarations());
    let mut text = format!("{BEGINNING}\nsyntax = \"proto3\";\n\npackage {PACKAGE};\n");
    all.enums.iter().for_each(|it| put_enum(&mut text, it));
    let messages = all.messages.iter().chain(&of_sheets);
    messages.for_each(|it| put_message(&mut text, it));
    text
}

fn put_enum(text: &mut String, it: &EnumDeclaration) {
    text.push('\n');
    put_comment(text, "", it.comment);
    text.push_str(&format!("enum {} {{\n", it.descriptor.name()));
    for (value, comment) in it.descriptor.value.iter().zip(&it.parts) {
        put_comment(text, "  ", comment);
        text.push_str(&format!("  {} = {};\n", value.name(), value.number()));
    }
    text.push_str("}\n");
}

fn put_message(text: &mut String, it: &MessageDeclaration) {
    text.push('\n');
    put_comment(text, "", it.comment);
    text.push_str(&format!("message {} {{\n", it.descriptor.name()));
    for (field, comment) in it.descriptor.field.iter().zip(&it.parts) {
        put_comment(text, "  ", comment);
        text.push_str(&format!("  {};\n", declared(field)));
    }
    text.push_str("}\n");
}

/// `repeated double positions = 4`.
fn declared(field: &FieldDescriptorProto) -> String {
    let label = match field.label() {
        Label::Repeated => "repeated ",
        _ if field.proto3_optional() => "optional ",
        _ => "",
    };
    let local = || field.type_name().trim_start_matches(&format!(".{PACKAGE}.")).to_owned();
    let kind = match field.r#type() {
        Type::Message | Type::Enum => local(),
        // TYPE_DOUBLE is `double`.
        scalar => scalar.as_str_name().trim_start_matches("TYPE_").to_lowercase(),
    };
    format!("{label}{kind} {} = {}", field.name(), field.number())
}

/// The comment without the marks of Rust's documentation: `\\[m\\]` is `[m]`, and a link its name.
fn put_comment(text: &mut String, indent: &str, comment: Comment) {
    for line in comment {
        let line = line.trim().replace("\\[", "[").replace("\\]", "]");
        let line = line.replace("[`", "`").replace("`]", "`");
        text.push_str(&format!("{indent}// {line}\n"));
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::recording::{schema_bytes, schema_of, sheet_schema_bytes};
    use foxglove::prost_types::{FileDescriptorProto, FileDescriptorSet};
    use prost::Message;
    use std::path::Path;

    fn in_the_tree() -> String {
        let path = Path::new(env!("CARGO_MANIFEST_DIR")).join("recording.proto");
        if std::env::var_os("CULLET_BLESS").is_some() {
            std::fs::write(&path, schema_text()).expect("writes");
        }
        std::fs::read_to_string(path).unwrap_or_default()
    }

    #[test]
    fn the_file_in_the_tree_is_the_declarations() {
        let written = in_the_tree();
        assert!(
            written == schema_text(),
            "run `cullet schema --recording > proto/recording.proto`"
        );
        let mut lines = written.lines().filter(|line| !line.trim_start().starts_with("//"));
        assert!(lines.all(|line| line.is_ascii() && line.len() <= 100));
        // Nothing of Rust's is left in what a stranger reads.
        let comments: Vec<&str> = written.lines().filter(|line| line.contains("// ")).collect();
        let rust = |line: &&&str| line.contains("::") || line.contains('\\');
        assert_eq!(comments.iter().find(rust), None);
    }

    /// What a recording embeds, as `message field = number: type`, from the file that this code
    /// did not write.
    fn embedded() -> Vec<String> {
        let set = FileDescriptorSet::decode(&sheet_schema_bytes()[..]).expect("a descriptor set");
        let file: &FileDescriptorProto = &set.file[0];
        let mut rows = Vec::new();
        for it in &file.enum_type {
            let name = it.name();
            rows.extend(it.value.iter().map(|v| format!("{name}: {} = {}", v.name(), v.number())));
        }
        for it in set.file.iter().flat_map(|file| &file.message_type) {
            for field in &it.field {
                let kind = match field.type_name.as_deref() {
                    Some(name) => name.replace(".cullet.", ""),
                    None => match field.r#type() {
                        Type::Double => "double".to_owned(),
                        Type::Float => "float".to_owned(),
                        Type::Uint64 => "uint64".to_owned(),
                        Type::Uint32 => "uint32".to_owned(),
                        Type::Bool => "bool".to_owned(),
                        Type::String => "string".to_owned(),
                        Type::Bytes => "bytes".to_owned(),
                        other => panic!("{other:?} is new here"),
                    },
                };
                let label = match (field.label(), field.proto3_optional()) {
                    (Label::Repeated, _) => "repeated ",
                    (_, true) => "optional ",
                    _ => "",
                };
                let (name, number) = (field.name(), field.number());
                rows.push(format!("{}: {label}{kind} {name} = {number}", it.name()));
            }
        }
        rows
    }

    #[test]
    fn the_file_in_the_tree_describes_what_a_recording_embeds() {
        let written = in_the_tree();
        let mut rows = Vec::new();
        let mut of = "";
        for line in written.lines().map(str::trim).filter(|line| !line.starts_with("//")) {
            if let Some(head) = line.strip_suffix(" {") {
                of = head.split_once(' ').expect("a kind and a name").1;
            } else if let Some(part) = line.strip_suffix(';').filter(|_| !of.is_empty()) {
                rows.push(format!("{of}: {part}"));
            }
        }
        assert_eq!(rows, embedded());
    }

    /// A recording without sheets embeds what it did before there were any.
    #[test]
    fn messages_of_sheets_have_a_schema_of_their_own() {
        let names = |bytes: &[u8]| -> Vec<Vec<String>> {
            let set = FileDescriptorSet::decode(bytes).expect("a descriptor set");
            let of = |file: &FileDescriptorProto| {
                file.message_type.iter().map(|it| it.name().to_owned()).collect()
            };
            set.file.iter().map(of).collect()
        };
        let [plain] = &names(&schema_bytes())[..] else { panic!("one file") };
        assert!(plain.iter().all(|name| !name.starts_with("Sheet")), "{plain:?}");
        let both = names(&sheet_schema_bytes());
        assert_eq!(&both[0], plain);
        assert!(both[1].iter().all(|name| name.starts_with("Sheet")), "{both:?}");
        assert_eq!(schema_of("cullet.Body"), schema_bytes());
        for name in &both[1] {
            assert_eq!(schema_of(&format!("cullet.{name}")), sheet_schema_bytes());
        }
    }
}
