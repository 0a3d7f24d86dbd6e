// SPDX-License-Identifier: MIT
// Every Vulkan function that the library calls.
#pragma once

// Those that can fail.
#define FAILABLE_INSTANCE_CALLS(X)                                                                                     \
    X(vkCreateDebugUtilsMessengerEXT)                                                                                  \
    X(vkCreateDevice)                                                                                                  \
    X(vkCreateInstance)                                                                                                \
    X(vkEnumerateDeviceExtensionProperties)                                                                            \
    X(vkEnumerateInstanceExtensionProperties)                                                                          \
    X(vkEnumeratePhysicalDevices)
#define FAILABLE_DEVICE_CALLS(X)                                                                                       \
    X(vkAllocateCommandBuffers)                                                                                        \
    X(vkAllocateDescriptorSets)                                                                                        \
    X(vkAllocateMemory)                                                                                                \
    X(vkBeginCommandBuffer)                                                                                            \
    X(vkBindBufferMemory)                                                                                              \
    X(vkCreateBuffer)                                                                                                  \
    X(vkCreateBufferView)                                                                                              \
    X(vkCreateCommandPool)                                                                                             \
    X(vkCreateComputePipelines)                                                                                        \
    X(vkCreateDescriptorPool)                                                                                          \
    X(vkCreateDescriptorSetLayout)                                                                                     \
    X(vkCreateFence)                                                                                                   \
    X(vkCreatePipelineCache)                                                                                           \
    X(vkCreatePipelineLayout)                                                                                          \
    X(vkCreateShaderModule)                                                                                            \
    X(vkEndCommandBuffer)                                                                                              \
    X(vkMapMemory)                                                                                                     \
    X(vkQueueSubmit)                                                                                                   \
    X(vkResetCommandBuffer)                                                                                            \
    X(vkResetFences)                                                                                                   \
    X(vkWaitForFences)

// Those that return nothing: what ends an object, records or changes one, and what only tells.
#define ENDING_CALLS(X)                                                                                                \
    X(vkDestroyBuffer)                                                                                                 \
    X(vkDestroyBufferView)                                                                                             \
    X(vkDestroyCommandPool)                                                                                            \
    X(vkDestroyDescriptorPool)                                                                                         \
    X(vkDestroyDescriptorSetLayout)                                                                                    \
    X(vkDestroyDevice)                                                                                                 \
    X(vkDestroyFence)                                                                                                  \
    X(vkDestroyPipeline)                                                                                               \
    X(vkDestroyPipelineCache)                                                                                          \
    X(vkDestroyPipelineLayout)                                                                                         \
    X(vkDestroyShaderModule)                                                                                           \
    X(vkFreeCommandBuffers)                                                                                            \
    X(vkFreeMemory)
#define ENDING_INSTANCE_CALLS(X)                                                                                       \
    X(vkDestroyDebugUtilsMessengerEXT)                                                                                 \
    X(vkDestroyInstance)
#define RECORDING_CALLS(X)                                                                                             \
    X(vkCmdBindDescriptorSets)                                                                                         \
    X(vkCmdBindPipeline)                                                                                               \
    X(vkCmdCopyBuffer)                                                                                                 \
    X(vkCmdDispatch)                                                                                                   \
    X(vkCmdFillBuffer)                                                                                                 \
    X(vkCmdPipelineBarrier)                                                                                            \
    X(vkCmdPushConstants)                                                                                              \
    X(vkCmdUpdateBuffer)                                                                                               \
    X(vkCmdWriteTimestamp)                                                                                             \
    X(vkUpdateDescriptorSets)
#define TELLING_CALLS(X)                                                                                               \
    X(vkCmdBeginDebugUtilsLabelEXT)                                                                                    \
    X(vkCmdEndDebugUtilsLabelEXT)                                                                                      \
    X(vkGetBufferMemoryRequirements)                                                                                   \
    X(vkGetDeviceQueue)                                                                                                \
    X(vkGetPhysicalDeviceMemoryProperties)                                                                             \
    X(vkGetPhysicalDeviceProperties)                                                                                   \
    X(vkGetPhysicalDeviceProperties2)                                                                                  \
    X(vkGetPhysicalDeviceQueueFamilyProperties)
