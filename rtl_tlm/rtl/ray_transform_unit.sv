// SPDX-License-Identifier: Apache-2.0
// Ray-transform unit of the RT unit: COUNT pipelines, each of which takes a ray through a 3 x 4 matrix at an edge and
// gives the reciprocals of its direction, behind one queue. Sums and reciprocals are rounded as the tracer's.
// Pins and timing: docs/model/rtl_bridge.md. Paper: GRTX, Section IV-B.

// Steps: products, sums of two, sums of all, three parts of a division.
module ray_transform_pipeline #(
    parameter STAGES = 6,  // registers from input to result
    parameter TAG = 13     // bits that go along
) (
    input  logic           clk,
    input  logic           rst,
    input  logic           step,
    input  logic           in_valid,
    input  logic [TAG-1:0] in_tag,
    input  logic [287:0]   in_matrix,       // row by row, the first entry lowest
    input  logic [95:0]    in_translation,
    input  logic [95:0]    in_origin,
    input  logic [95:0]    in_direction,
    input  logic [1:0]     fault,           // constant 0 but in the tests
    output logic           out_valid,
    output logic [TAG-1:0] out_tag,
    output logic [95:0]    out_origin,
    output logic [95:0]    out_direction,
    output logic [95:0]    out_inverse
);
/*verilator no_inline_module*/
`include "fp32.svh"
  localparam STEPS = 6;
  logic [STEPS:0] valid /*verilator split_var*/;
  logic [TAG-1:0] tag [STEPS + 1] /*verilator split_var*/;
  assign valid[0] = in_valid;
  assign tag[0] = in_tag;
  assign out_valid = valid[STEPS];
  assign out_tag = tag[STEPS];

  // Registers behind each step, the first step's lowest. Beyond one each they go where the work is: WORK is how many more a
  // step needs for the clock of the machine (docs/results/rtl.md).
  localparam [6*8-1:0] WORK = {8'd9, 8'd5, 8'd6, 8'd7, 8'd7, 8'd5};
  function [6*4-1:0] cuts(input integer stages);
    integer sum, so_far, total;
    total = 0;
    sum = 0;
    for (int i = 0; i < STEPS; i = i + 1) total = total + 32'(WORK[i*8 +: 8]);
    for (int i = 0; i < STEPS; i = i + 1) begin
      so_far = sum;
      sum = sum + 32'(WORK[i*8 +: 8]);
      cuts[i*4 +: 4] = stages <= STEPS ? 4'((i + 1) * stages / STEPS - i * stages / STEPS)
                                       : 4'(1 + (stages - STEPS) * sum / total - (stages - STEPS) * so_far / total);
    end
  endfunction
  localparam [6*4-1:0] CUTS = cuts(STAGES);
  genvar k;
  generate
    for (k = 0; k < STEPS; k = k + 1) begin : stage
      intersection_valid #(CUTS[k*4 +: 4]) of_valid(clk, rst, step, valid[k], valid[k + 1]);
      intersection_cut #(TAG, CUTS[k*4 +: 4]) of_tag(clk, step, valid[k], tag[k], tag[k + 1]);
    end
  endgenerate

  logic [671:0] to_0, from_1;  // translation, nine products of the direction, nine of the origin
  logic [383:0] to_1, from_2;  // of the direction z and x + y; of the origin z + translation and x + y
  logic [191:0] to_2, from_3, from_4, from_5;  // direction, origin
  logic [3*FP_DIVISION-1:0] to_3, division_4, to_4, division_5;
  logic [287:0] to_5;

  always_comb begin
    to_0 = 'x;
    if (valid[0]) begin
      for (int i = 0; i < 9; i = i + 1) begin
        to_0[i*32 +: 32] = fp_mul(in_matrix[i*32 +: 32], in_origin[(i % 3)*32 +: 32]);
        to_0[(9 + i)*32 +: 32] = fp_mul(in_matrix[i*32 +: 32], in_direction[(i % 3)*32 +: 32]);
      end
      to_0[671:576] = fault == 2'd3 ? {in_translation[63:0], in_translation[95:64]} : in_translation;
    end
  end
  always_comb begin
    to_1 = 'x;
    if (valid[1]) begin
      for (int i = 0; i < 3; i = i + 1) begin
        to_1[i*32 +: 32] = fp_add(from_1[3*i*32 +: 32], from_1[(3*i + 1)*32 +: 32]);
        to_1[(3 + i)*32 +: 32] = fp_add(from_1[(3*i + 2)*32 +: 32], from_1[(18 + i)*32 +: 32]);
        to_1[(6 + i)*32 +: 32] = fp_add(from_1[(9 + 3*i)*32 +: 32], from_1[(10 + 3*i)*32 +: 32]);
        to_1[(9 + i)*32 +: 32] = from_1[(11 + 3*i)*32 +: 32];
      end
    end
  end
  always_comb begin
    to_2 = 'x;
    if (valid[2]) begin
      for (int i = 0; i < 3; i = i + 1) begin
        to_2[i*32 +: 32] = fp_add(from_2[i*32 +: 32], from_2[(3 + i)*32 +: 32]);
        to_2[(3 + i)*32 +: 32] = fp_add(from_2[(6 + i)*32 +: 32], from_2[(9 + i)*32 +: 32]);
      end
    end
  end
  always_comb begin
    to_3 = 'x;
    if (valid[3]) begin
      for (int i = 0; i < 3; i = i + 1) to_3[i*FP_DIVISION +: FP_DIVISION] = fp_divide_begin(from_3[(3 + i)*32 +: 32]);
    end
  end
  always_comb begin
    to_4 = 'x;
    if (valid[4]) begin
      for (int i = 0; i < 3; i = i + 1) begin
        to_4[i*FP_DIVISION +: FP_DIVISION] =
            fp_divide(from_4[(3 + i)*32 +: 32], division_4[i*FP_DIVISION +: FP_DIVISION]);
      end
    end
  end
  always_comb begin
    to_5 = 'x;
    if (valid[5]) begin
      to_5[191:0] = from_5;
      for (int i = 0; i < 3; i = i + 1) begin
        to_5[192 + i*32 +: 32] = fp_reciprocal(from_5[(3 + i)*32 +: 32], division_5[i*FP_DIVISION +: FP_DIVISION]);
        // The wrong comparison: the sign is that of what is not above zero.
        if (fault == 2'd1 && from_5[(3 + i)*32 +: 31] == 31'd0) to_5[192 + i*32 + 31] = 1'b1;
      end
    end
  end
  intersection_cut #(672, CUTS[0*4 +: 4]) cut_0(clk, step, valid[0], to_0, from_1);
  intersection_cut #(384, CUTS[1*4 +: 4]) cut_1(clk, step, valid[1], to_1, from_2);
  intersection_cut #(192, CUTS[2*4 +: 4]) cut_2(clk, step, valid[2], to_2, from_3);
  intersection_cut #(192, CUTS[3*4 +: 4]) cut_3(clk, step, valid[3], from_3, from_4);
  intersection_cut #(3*FP_DIVISION, CUTS[3*4 +: 4]) divide_3(clk, step, valid[3], to_3, division_4);
  intersection_cut #(192, CUTS[4*4 +: 4]) cut_4(clk, step, valid[4], from_4, from_5);
  intersection_cut #(3*FP_DIVISION, CUTS[4*4 +: 4]) divide_4(clk, step, valid[4], to_4, division_5);
  intersection_cut #(288, CUTS[5*4 +: 4]) cut_5(clk, step, valid[5], to_5, {out_inverse, out_direction, out_origin});
endmodule

module ray_transform_unit #(
    parameter COUNT = 4,                // pipelines
    parameter STAGES = 6,               // of a pipeline
    parameter LONGEST = 0,              // edges by which the straps can delay a result
    parameter RAYS = 256,               // warp buffer entries x 32
    parameter RAY_BITS = $clog2(RAYS),
    parameter TAG = RAY_BITS + 5        // ray, number of its test, last
) (
    input  logic                      clk,
    input  logic                      rst,               // synchronous
    input  logic                      step,              // time passes: a cycle of the unit
    // Straps: constant while the unit works.
    input  logic [3:0]                cfg_count,         // 1 to COUNT
    input  logic [6:0]                cfg_interval,      // edges between two tests of a pipeline, 1 to 127
    input  logic [6:0]                cfg_delay,         // 0 to LONGEST: latency less STAGES
`ifdef INTERSECTION_FAULTS
    input  logic [1:0]                fault,             // 1 comparison, 2 lost entry, 3 row of the translation
`endif
    // A ray asks for the transform of its instance.
    input  logic                      push_valid,
    output logic                      push_ready,
    input  logic [RAY_BITS-1:0]       push_ray,
    // Rays that leave the queue at the next step, and how many transforms each asks for.
    output logic [COUNT-1:0]          start_valid,
    output logic [COUNT*RAY_BITS-1:0] start_ray,
    input  logic [COUNT*4-1:0]        start_tests,
    // Transforms that begin at the next step, and their operands.
    output logic [COUNT-1:0]          test_valid,
    output logic [COUNT*RAY_BITS-1:0] test_ray,
    output logic [COUNT*4-1:0]        test_number,
    input  logic [COUNT*288-1:0]      test_matrix,
    input  logic [COUNT*96-1:0]       test_translation,
    input  logic [COUNT*96-1:0]       test_origin,
    input  logic [COUNT*96-1:0]       test_direction,
    // Results, there until the next step.
    output logic [COUNT-1:0]          result_valid,
    output logic [COUNT*RAY_BITS-1:0] result_ray,
    output logic [COUNT*4-1:0]        result_number,
    output logic [COUNT-1:0]          result_last,       // the ray's
    output logic [COUNT*96-1:0]       result_origin,
    output logic [COUNT*96-1:0]       result_direction,
    output logic [COUNT*96-1:0]       result_inverse,
    // State.
    output logic [RAY_BITS:0]         level,             // rays in the queue
    output logic [COUNT-1:0]          busy,              // pipelines that can start nothing
    output logic [RAY_BITS:0]         in_flight,         // rays that have started and have no result yet
    output logic                      idle               // no ray in it
);
`ifndef INTERSECTION_FAULTS
  logic [1:0] fault;
  assign fault = 2'd0;
`endif
  logic [COUNT-1:0] test_last;
  logic [RAY_BITS:0] starts, ends;

  intersection_queue #(.COUNT(COUNT), .RAYS(RAYS), .RAY_BITS(RAY_BITS)) rays(
      .clk(clk), .rst(rst), .step(step), .cfg_count(cfg_count), .cfg_interval(cfg_interval), .fault(fault == 2'd2),
      .push_valid(push_valid), .push_ready(push_ready), .push_ray(push_ray), .start_valid(start_valid),
      .start_ray(start_ray), .start_tests(start_tests), .test_valid(test_valid), .test_ray(test_ray),
      .test_number(test_number), .test_last(test_last), .busy(busy), .level(level));

  genvar p;
  generate
    for (p = 0; p < COUNT; p = p + 1) begin : pipeline
      logic           valid;
      logic [TAG-1:0] tag, out_tag;
      logic [95:0]    origin, direction, inverse;
      ray_transform_pipeline #(.STAGES(STAGES), .TAG(TAG)) transform(
          .clk(clk), .rst(rst), .step(step), .in_valid(test_valid[p]),
          .in_tag({test_last[p], test_number[p*4 +: 4], test_ray[p*RAY_BITS +: RAY_BITS]}),
          .in_matrix(test_matrix[p*288 +: 288]), .in_translation(test_translation[p*96 +: 96]),
          .in_origin(test_origin[p*96 +: 96]), .in_direction(test_direction[p*96 +: 96]), .fault(fault),
          .out_valid(valid), .out_tag(tag), .out_origin(origin), .out_direction(direction), .out_inverse(inverse));
      intersection_delay #(.WIDTH(TAG + 288), .LONGEST(LONGEST)) delay(
          .clk(clk), .rst(rst), .step(step), .cfg_delay(cfg_delay), .in_valid(valid),
          .in({tag, inverse, direction, origin}), .out_valid(result_valid[p]),
          .out({out_tag, result_inverse[p*96 +: 96], result_direction[p*96 +: 96], result_origin[p*96 +: 96]}));
      assign result_ray[p*RAY_BITS +: RAY_BITS] = out_tag[RAY_BITS-1:0];
      assign result_number[p*4 +: 4] = out_tag[RAY_BITS +: 4];
      assign result_last[p] = out_tag[TAG-1];
    end
  endgenerate

  always_comb begin
    starts = '0;
    ends = '0;
    for (int i = 0; i < COUNT; i = i + 1) begin
      starts = starts + {{RAY_BITS{1'b0}}, start_valid[i]};
      ends = ends + {{RAY_BITS{1'b0}}, result_valid[i] & result_last[i]};
    end
  end
  assign idle = level == '0 & in_flight == '0;
  always_ff @(posedge clk) begin
    if (rst) in_flight <= '0;
    else if (step) in_flight <= in_flight + starts - ends;
  end
endmodule
