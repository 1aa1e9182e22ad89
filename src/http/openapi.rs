//! The OpenAPI document: generated from the handlers, committed as `openapi/landmarkd.json`, compared in a test.

use utoipa::OpenApi;
use utoipa::openapi::path::Operation;
use utoipa::openapi::schema::{KnownFormat, ObjectBuilder, SchemaFormat, Type};
use utoipa::openapi::{Content, ContentBuilder, Ref, RefOr, ResponseBuilder};

use super::problem::ProblemBody;
use super::{access, routes};

#[derive(OpenApi)]
#[openapi(
    info(
        title = "landmarkd",
        description = "Robots ask where they are and what they see: places and objects by local appearance, \
                       objects and how they are turned by their whole appearance, how far away everything is by \
                       two focal settings, which parts are on a table and where to reach, with the evidence behind each answer. Coordinates are pixels, x right, y down, origin at the \
                       centre of the top-left pixel. Errors are RFC 9457 problem documents.",
        license(name = "MIT OR Apache-2.0", identifier = "MIT OR Apache-2.0")
    ),
    components(schemas(ProblemBody)),
    tags(
        (name = "service", description = "Is it alive, what can it do"),
        (name = "databases", description = "Exemplars, versions and aliases under a name"),
        (name = "recognition", description = "Ask a frame what it shows"),
        (name = "cameras", description = "Intrinsics under a name, which pictures then name"),
        (name = "depth", description = "How far away everything is, from a near- and a far-focused picture"),
        (name = "workcell", description = "Find every part on a table, say what it is, and where to reach"),
        (name = "jobs", description = "Long work, watched and cancelled"),
        (name = "inference protocol", description = "Health and metadata as the Open Inference Protocol has them"),
        (name = "access", description = "Who may call, and who changed what"),
    )
)]
struct Preamble;

/// The document without the routes.
pub(super) fn preamble() -> utoipa::openapi::OpenApi {
    Preamble::openapi()
}

/// Adds to the document how a key is sent, files as bytes, and the problem document as the response for every status that
/// an operation doesn't name.
pub(super) fn finished(mut document: utoipa::openapi::OpenApi) -> utoipa::openapi::OpenApi {
    access::describe(&mut document);
    let problem = ResponseBuilder::new()
        .description("A problem document: what went wrong and what to do")
        .content(
            "application/problem+json",
            ContentBuilder::new().schema(Some(Ref::from_schema_name("Problem"))).build(),
        )
        .build();
    for item in document.paths.paths.values_mut() {
        let operations: [&mut Option<Operation>; 5] =
            [&mut item.get, &mut item.put, &mut item.post, &mut item.delete, &mut item.patch];
        for operation in operations.into_iter().flatten() {
            if let Some(RefOr::T(sent)) = &mut operation.request_body {
                sent.content.iter_mut().for_each(|(kind, content)| file_as_bytes(kind, content));
            }
            for response in operation.responses.responses.values_mut() {
                let RefOr::T(response) = response else { continue };
                if response.description.is_empty() {
                    response.description = "The answer".into();
                }
                response.content.iter_mut().for_each(|(kind, content)| file_as_bytes(kind, content));
            }
            operation.responses.responses.insert("default".into(), problem.clone().into());
        }
    }
    document
}

/// Describes content that is neither JSON, a form nor text as a file, in the way that generators of clients know.
fn file_as_bytes(kind: &str, content: &mut RefOr<Content>) {
    let is_file = !kind.ends_with("json") && !kind.starts_with("multipart/") && !kind.starts_with("text/");
    if let (true, RefOr::T(content)) = (is_file, content) {
        let format = SchemaFormat::KnownFormat(KnownFormat::Binary);
        content.schema =
            Some(ObjectBuilder::new().schema_type(Type::String).format(Some(format)).build().into());
    }
}

/// The whole document.
pub fn document() -> utoipa::openapi::OpenApi {
    finished(routes().into_openapi())
}

/// The whole document as it is committed: pretty JSON with a line's end.
pub fn text() -> String {
    let text = document().to_pretty_json();
    text.expect("the document is made of text and numbers") + "\n"
}
