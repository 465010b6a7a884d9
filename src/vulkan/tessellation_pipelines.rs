//! Pipelines that evaluate and discard: tessellation by the degrees of its patches, and the mesh shader beside it.

use super::{Device, VulkanError};
use ash::vk;
use std::io::Cursor;
use std::sync::Arc;

/// What shaders are told at each draw: `push` of vk_shaders/tessellation.glsl.
#[derive(Clone, Copy, Debug, Default)]
#[repr(C)]
pub(super) struct TessellationPush {
    pub patches: u64,
    /// Pieces and nets, or meshlets and points.
    pub list: u64,
    pub values: u64,
    pub samples: u64,
    /// Of the list: first, and one past the last.
    pub first: u32,
    pub count: u32,
    /// Pixel in the viewport's middle, and half the viewport's side.
    pub middle: [i32; 2],
    pub half_viewport: i32,
    pub perspective: u32,
    pub near: f32,
    pub depth_slope: f32,
    /// More than any sum of a vertex' coordinates.
    pub sentinel: f32,
    pub unused: u32,
}

const PUSH_BYTES: u32 = size_of::<TessellationPush>() as u32;
const _: () = assert!(PUSH_BYTES <= 128);

/// What a pipeline does.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(super) enum Work {
    Tessellate { degree: [u8; 2], exact: bool },
    Meshlets,
}

/// Pipelines, made when they are first asked for.
pub(super) struct TessellationPipelines {
    pub layout: vk::PipelineLayout,
    modules: Vec<vk::ShaderModule>,
    /// What each does, and whether it stores vertices.
    all: Vec<(Work, bool, vk::Pipeline)>,
    device: Arc<Device>,
}

type Stages = vk::ShaderStageFlags;

const SHADERS: [(Stages, &[u8]); 4] = [
    (Stages::VERTEX, include_bytes!("../../vk_shaders/tessellation.vert.spv")),
    (Stages::TESSELLATION_CONTROL, include_bytes!("../../vk_shaders/tessellation.tesc.spv")),
    (Stages::TESSELLATION_EVALUATION, include_bytes!("../../vk_shaders/tessellation.tese.spv")),
    (Stages::MESH_EXT, include_bytes!("../../vk_shaders/evaluated.mesh.spv")),
];

/// The stages that read what is pushed.
const PUSHED: Stages = Stages::from_raw(
    Stages::TESSELLATION_CONTROL.as_raw() | Stages::TESSELLATION_EVALUATION.as_raw() | Stages::MESH_EXT.as_raw(),
);

impl TessellationPipelines {
    pub fn new(device: &Arc<Device>) -> Result<Self, VulkanError> {
        let ranges = [vk::PushConstantRange::default().stage_flags(PUSHED).size(PUSH_BYTES)];
        let info = vk::PipelineLayoutCreateInfo::default().push_constant_ranges(&ranges);
        // SAFETY: `info` is valid and the device is alive.
        let layout = unsafe { device.raw.create_pipeline_layout(&info, None) };
        let layout = layout.map_err(VulkanError::of("vkCreatePipelineLayout"))?;
        let mut made = Self { layout, modules: Vec::new(), all: Vec::new(), device: device.clone() };
        for (_, code) in SHADERS {
            let words = ash::util::read_spv(&mut Cursor::new(code)).unwrap_or_default();
            let info = vk::ShaderModuleCreateInfo::default().code(&words);
            // SAFETY: what glslang wrote of vk_shaders/, which tests/shaders.rs keeps fresh.
            let module = unsafe { device.raw.create_shader_module(&info, None) };
            made.modules.push(module.map_err(VulkanError::of("vkCreateShaderModule"))?);
        }
        Ok(made)
    }

    /// `stores`: what is emitted is stored too.
    pub fn of(&mut self, work: Work, stores: bool) -> Result<vk::Pipeline, VulkanError> {
        if let Some((_, _, pipeline)) = self.all.iter().find(|(w, s, _)| (*w, *s) == (work, stores)) {
            return Ok(*pipeline);
        }
        let pipeline = self.pipeline(work, stores)?;
        self.all.push((work, stores, pipeline));
        Ok(pipeline)
    }

    fn pipeline(&self, work: Work, stores: bool) -> Result<vk::Pipeline, VulkanError> {
        let (first, constants) = match work {
            Work::Meshlets => (3, vec![u32::from(stores)]),
            Work::Tessellate { degree: [m, n], exact } => {
                (0, vec![u32::from(stores), u32::from(m), u32::from(n), u32::from(exact)])
            }
        };
        let bytes: Vec<u8> = constants.iter().flat_map(|c| c.to_ne_bytes()).collect();
        let entries: Vec<_> = (0..constants.len() as u32)
            .map(|k| vk::SpecializationMapEntry::default().constant_id(k).offset(4 * k).size(4))
            .collect();
        let special = vk::SpecializationInfo::default().map_entries(&entries).data(&bytes);
        let shaders = if work == Work::Meshlets { first..4 } else { first..3 };
        let stages: Vec<_> = shaders
            .map(|k| {
                let (stage, module) = (SHADERS[k].0, self.modules[k]);
                let info = vk::PipelineShaderStageCreateInfo::default().stage(stage).module(module).name(c"main");
                let has_constants = [Stages::TESSELLATION_EVALUATION, Stages::MESH_EXT].contains(&stage);
                if has_constants { info.specialization_info(&special) } else { info }
            })
            .collect();
        let vertices = vk::PipelineVertexInputStateCreateInfo::default();
        let assembly = vk::PipelineInputAssemblyStateCreateInfo::default().topology(vk::PrimitiveTopology::PATCH_LIST);
        let tessellation = vk::PipelineTessellationStateCreateInfo::default().patch_control_points(1);
        // As in ETER's table 3: no triangle is rasterised.
        let raster =
            vk::PipelineRasterizationStateCreateInfo::default().rasterizer_discard_enable(true).line_width(1.0);
        let mut rendering = vk::PipelineRenderingCreateInfo::default();
        let mut info = vk::GraphicsPipelineCreateInfo::default()
            .stages(&stages)
            .rasterization_state(&raster)
            .layout(self.layout)
            .push_next(&mut rendering);
        if work != Work::Meshlets {
            info = info.vertex_input_state(&vertices).input_assembly_state(&assembly).tessellation_state(&tessellation);
        }
        // SAFETY: all that `info` points to lives until the call returns.
        let made = unsafe { self.device.raw.create_graphics_pipelines(vk::PipelineCache::null(), &[info], None) };
        let made = made.map_err(|(_, code)| VulkanError::of("vkCreateGraphicsPipelines")(code))?;
        Ok(made[0])
    }

    /// Tells the shaders of the next draw.
    pub fn push(&self, commands: vk::CommandBuffer, push: &TessellationPush) {
        // SAFETY: `TessellationPush` is numbers without padding, of the size that the layout has; commands are being recorded.
        unsafe {
            let bytes = std::slice::from_raw_parts((&raw const *push).cast::<u8>(), PUSH_BYTES as usize);
            self.device.raw.cmd_push_constants(commands, self.layout, PUSHED, 0, bytes);
        }
    }
}

impl Drop for TessellationPipelines {
    fn drop(&mut self) {
        // SAFETY: the device is done with them: `Recorder` waits for all that it has run.
        unsafe {
            self.all.iter().for_each(|(_, _, pipeline)| self.device.raw.destroy_pipeline(*pipeline, None));
            self.modules.iter().for_each(|module| self.device.raw.destroy_shader_module(*module, None));
            self.device.raw.destroy_pipeline_layout(self.layout, None);
        }
    }
}
