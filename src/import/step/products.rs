//! Products, their shapes and their use in assemblies (ISO 10303-41 and -44).

use super::file::File;
use super::kinds::Kind;
use std::collections::{BTreeMap, HashMap};

/// A product as a component of another.
pub(super) struct Usage {
    pub id: u32,
    /// The shape definition of the usage, which styles may name.
    pub place: u32,
    /// The entity that joins this to the relationship which places it.
    pub dependent: u32,
    pub name: String,
    /// Product definitions.
    pub parent: u32,
    pub child: u32,
}

/// What the file says of products.
#[derive(Default)]
pub(super) struct Products {
    /// By representation: names, and the product definitions' numbers.
    names: HashMap<u32, String>,
    numbers: HashMap<u32, u32>,
    /// Representations by product definition.
    shapes: HashMap<u32, u32>,
    usages: Vec<Usage>,
    /// Indices of usages by the relationship that places them.
    by_relation: HashMap<u32, Vec<usize>>,
    /// Other numbers and the product definitions that they stand for.
    aliases: Vec<[u32; 2]>,
    /// Names of files by product definition.
    files: BTreeMap<u32, Vec<String>>,
}

impl Products {
    pub fn new(file: &File) -> Self {
        let mut products = Self::default();
        let mut usage_by_id = HashMap::new();
        for entity in file.entities() {
            if entity.kind == Kind::NextAssemblyUsageOccurrence {
                let Ok(mut args) = entity.args() else { continue };
                let [number, name] = [args.text(), args.text()];
                let mut args = args.skip(1);
                let Some((parent, child)) = args.optional_reference().zip(args.optional_reference()) else { continue };
                let name = if name.is_empty() { number } else { name };
                usage_by_id.insert(entity.id, products.usages.len());
                products.usages.push(Usage { id: entity.id, place: 0, dependent: 0, name, parent, child });
            } else if entity.kind == Kind::ShapeDefinitionRepresentation {
                let Ok(mut args) = entity.args() else { continue };
                let both = args.optional_reference().zip(args.optional_reference());
                let Some((definition, shape)) = both else { continue };
                let Some(product) = definition_of(file, definition) else { continue };
                products.shapes.entry(product).or_insert(shape);
                products.numbers.entry(shape).or_insert(product);
                if let Some(ProductName { name, numbers }) = product_name(file, product) {
                    products.names.extend((!name.is_empty()).then_some((shape, name)));
                    products.aliases.extend(numbers.map(|number| [number, product]));
                }
            }
        }
        for entity in file.entities().filter(|e| e.kind == Kind::ContextDependentShapeRepresentation) {
            let Ok(mut args) = entity.args() else { continue };
            let Some((relation, place)) = args.optional_reference().zip(args.optional_reference()) else { continue };
            let usage = definition_of(file, place).and_then(|usage| usage_by_id.get(&usage).copied());
            if let Some(index) = usage {
                (products.usages[index].place, products.usages[index].dependent) = (place, entity.id);
                products.by_relation.entry(relation).or_default().push(index);
            }
        }
        products.files = referenced_files(file, &products.aliases);
        products
    }

    /// The name of the product whose shape this representation is.
    pub fn name(&self, representation: u32) -> Option<&str> {
        self.names.get(&representation).map(String::as_str)
    }

    /// The product definition whose shape this representation is.
    pub fn number(&self, representation: u32) -> Option<u32> {
        self.numbers.get(&representation).copied()
    }

    /// The representation of a product definition's shape.
    pub fn shape(&self, product: u32) -> Option<u32> {
        self.shapes.get(&product).copied()
    }

    /// The numbers of products and their versions, each with that of a product definition.
    pub fn aliases(&self) -> Vec<[u32; 2]> {
        self.aliases.clone()
    }

    /// Product definitions with the STEP files that are said to hold their shapes.
    pub fn files(&self) -> impl Iterator<Item = (&u32, &Vec<String>)> {
        self.files.iter()
    }

    pub fn usages(&self) -> impl Iterator<Item = &Usage> {
        self.usages.iter()
    }

    /// The usages that a relationship between representations places.
    pub fn usages_of(&self, relation: u32) -> Vec<&Usage> {
        let indices = self.by_relation.get(&relation).map_or(&[][..], Vec::as_slice);
        indices.iter().map(|&k| &self.usages[k]).collect()
    }
}

/// What a shape definition defines the shape of.
fn definition_of(file: &File, id: u32) -> Option<u32> {
    let args = file.args(id, Kind::ProductDefinitionShape, "the shape of a product").ok()?;
    args.skip(2).optional_reference()
}

/// A product definition's product.
struct ProductName {
    /// Empty where it has none.
    name: String,
    /// Of the product and of its version.
    numbers: [u32; 2],
}

fn product_name(file: &File, id: u32) -> Option<ProductName> {
    let definition = file.get(id).ok()?;
    matches!(definition.kind, Kind::ProductDefinition | Kind::ProductDefinitionWithDocuments).then_some(())?;
    let formation = file.get(definition.args().ok()?.skip(2).optional_reference()?).ok()?;
    let product = formation.args().ok()?.skip(2).optional_reference()?;
    let mut args = file.args(product, Kind::Product, "a product").ok()?;
    let [id, name] = [args.text(), args.text()];
    let name = if name.trim().is_empty() { id } else { name };
    let name = if name.trim().is_empty() { String::new() } else { name };
    Some(ProductName { name, numbers: [product, formation.id] })
}

/// The files that product definitions refer to for their shapes: documents that are assigned to them, by the names that
/// identify these outside (recommended practices for external references, AP203 edition 2, AP214 and AP242). Documents
/// that are no STEP files are drawings and the like.
fn referenced_files(file: &File, aliases: &[[u32; 2]]) -> BTreeMap<u32, Vec<String>> {
    let mut outside: HashMap<u32, String> = HashMap::new();
    let mut pairs: Vec<(u32, u32)> = Vec::new();
    let documents = |kind| {
        matches!(
            kind,
            Kind::DocumentFile
                | Kind::AppliedExternalIdentification
                | Kind::AppliedDocumentReference
                | Kind::ProductDefinitionWithDocuments
        )
    };
    for entity in file.entities().filter(|entity| documents(entity.kind)) {
        let Ok(mut args) = entity.args() else { continue };
        match entity.kind {
            Kind::DocumentFile => {
                outside.entry(entity.id).or_insert(args.text());
            }
            Kind::AppliedExternalIdentification => {
                let name = args.text();
                for document in args.skip(2).references().unwrap_or_default() {
                    outside.insert(document, name.clone());
                }
            }
            Kind::AppliedDocumentReference => {
                let document = args.optional_reference();
                let items = args.skip(1).references().unwrap_or_default();
                pairs.extend(document.iter().flat_map(|&d| items.iter().map(move |&item| (item, d))));
            }
            Kind::ProductDefinitionWithDocuments => {
                let documents = args.skip(4).references().unwrap_or_default();
                pairs.extend(documents.into_iter().map(|d| (entity.id, d)));
            }
            _ => {}
        }
    }
    let mut files: BTreeMap<u32, Vec<String>> = BTreeMap::new();
    for (item, document) in pairs {
        let Some(name) = outside.get(&document).filter(|name| is_step_name(name)) else { continue };
        let item = definition_of(file, item).unwrap_or(item);
        let product = aliases.iter().find(|alias| alias[0] == item).map_or(item, |alias| alias[1]);
        let is_definition = |kind| matches!(kind, Kind::ProductDefinition | Kind::ProductDefinitionWithDocuments);
        if file.get(product).is_ok_and(|entity| is_definition(entity.kind)) {
            files.entry(product).or_default().push(name.clone());
        }
    }
    files
}

fn is_step_name(name: &str) -> bool {
    let suffix = name.rsplit_once('.').map(|(_, suffix)| suffix.to_ascii_lowercase());
    suffix.is_some_and(|suffix| matches!(suffix.as_str(), "stp" | "step" | "p21"))
}
