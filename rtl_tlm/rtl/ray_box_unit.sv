// SPDX-License-Identifier: Apache-2.0
// Ray-box unit of the RT unit: COUNT pipelines, each of which tests a ray against the BOXES children of a node at an edge
// and sorts them by where the ray enters, behind one queue. The test is the tracer's, with its outward rounding.
// Pins and timing: docs/model/rtl_bridge.md. Paper: GRTX, Section IV-B.

// One child, steps 0 to 6 of the pipeline: subtract, multiply, largest entry and least exit of two axes, of three, offset
// of t, outward rounding, comparisons.
module ray_box_child #(
    parameter [7*4-1:0] CUTS = 28'h1111111  // registers after step k; those after step 6 are the pipeline's
) (
    input  logic        clk,
    input  logic        step,
    input  logic [6:0]  valid,      // at the input of step k
    input  logic        used,       // of step 0
    input  logic [95:0] lower,      // the box, x in the lowest bits
    input  logic [95:0] upper,
    input  logic [95:0] origin,
    input  logic [95:0] inverse_0,  // of the direction, at step 0
    input  logic [95:0] inverse_1,
    input  logic [31:0] t_offset_4,
    input  logic [31:0] t_min_6,
    input  logic [31:0] t_max_6,
    input  logic        fault,      // constant 0 but in the tests: a wrong comparison
    output logic [32:0] result      // of step 6: miss, entry t without its sign, beyond t_max
);
/*verilator no_inline_module*/
`include "fp32.svh"
  localparam [31:0] NARROWED = 32'h3f7ffffa, WIDENED = 32'h3f800003;  // 1 -+ 2 gamma(3)
  logic [191:0] to_0, from_1, to_1, from_2;  // entries at x, y, z; exits at x, y, z
  logic [127:0] to_2, from_3;                // entry, that at z, exit, that at z
  logic [63:0]  to_3, from_4, to_4, from_5, to_5, from_6;
  logic [6:0]   used_at /*verilator split_var*/;
  logic [6:0]   work;
  assign used_at[0] = used;
  assign work = valid & used_at;

  always_comb begin
    to_0 = 'x;
    if (work[0]) begin
      for (int i = 0; i < 3; i = i + 1) begin
        to_0[i*32 +: 32] = fp_add(inverse_0[i*32 + 31] ? upper[i*32 +: 32] : lower[i*32 +: 32],
                                  {~origin[i*32 + 31], origin[i*32 +: 31]});
        to_0[96 + i*32 +: 32] = fp_add(inverse_0[i*32 + 31] ? lower[i*32 +: 32] : upper[i*32 +: 32],
                                       {~origin[i*32 + 31], origin[i*32 +: 31]});
      end
    end
  end
  always_comb begin
    to_1 = 'x;
    if (work[1]) begin
      for (int i = 0; i < 3; i = i + 1) begin
        to_1[i*32 +: 32] = fp_mul(from_1[i*32 +: 32], inverse_1[i*32 +: 32]);
        to_1[96 + i*32 +: 32] = fp_mul(from_1[96 + i*32 +: 32], inverse_1[i*32 +: 32]);
      end
    end
  end
  // An entry that is not above the other gives way to it, also where one is no number; so does an exit not below.
  always_comb begin
    to_2 = 'x;
    if (work[2]) begin
      to_2 = {from_2[191:160], fp_less(from_2[127:96], from_2[159:128]) ? from_2[127:96] : from_2[159:128],
              from_2[95:64], fp_less(from_2[63:32], from_2[31:0]) ? from_2[31:0] : from_2[63:32]};
    end
  end
  always_comb begin
    to_3 = 'x;
    if (work[3]) begin
      to_3 = {fp_less(from_3[95:64], from_3[127:96]) ? from_3[95:64] : from_3[127:96],
              fp_less(from_3[63:32], from_3[31:0]) ? from_3[31:0] : from_3[63:32]};
    end
  end
  always_comb begin
    to_4 = 'x;
    if (work[4]) to_4 = {fp_add(from_4[63:32], t_offset_4), fp_add(from_4[31:0], t_offset_4)};
  end
  always_comb begin
    to_5 = 'x;
    if (work[5]) begin
      to_5 = {fp_mul(from_5[63:32], WIDENED), fp_mul(fp_less(32'd0, from_5[31:0]) ? from_5[31:0] : 32'd0, NARROWED)};
    end
  end
  always_comb begin
    result = {1'b1, 32'd0};
    if (work[6]) begin
      result = {~((fault ? fp_less(from_6[31:0], from_6[63:32]) : fp_less_equal(from_6[31:0], from_6[63:32])) &
                  fp_less_equal(t_min_6, from_6[63:32])),
                from_6[30:0], ~fp_less_equal(from_6[31:0], t_max_6)};
    end
  end
  intersection_cut #(192, CUTS[0*4 +: 4]) cut_0(clk, step, work[0], to_0, from_1);
  intersection_cut #(192, CUTS[1*4 +: 4]) cut_1(clk, step, work[1], to_1, from_2);
  intersection_cut #(128, CUTS[2*4 +: 4]) cut_2(clk, step, work[2], to_2, from_3);
  intersection_cut #(64, CUTS[3*4 +: 4]) cut_3(clk, step, work[3], to_3, from_4);
  intersection_cut #(64, CUTS[4*4 +: 4]) cut_4(clk, step, work[4], to_4, from_5);
  intersection_cut #(64, CUTS[5*4 +: 4]) cut_5(clk, step, work[5], to_5, from_6);
  genvar k;
  generate
    for (k = 0; k < 6; k = k + 1) begin : use_of
      intersection_cut #(1, CUTS[k*4 +: 4]) cut(clk, step, valid[k], used_at[k], used_at[k + 1]);
    end
  endgenerate
endmodule

// An exchange of the sort by entry t, then place in the node: 36 bits a child (miss, entry t, slot, beyond t_max).
module ray_box_pipeline #(
    parameter BOXES = 6,    // children of a node, 1 to 8
    parameter STAGES = 12,  // registers from input to result
    parameter TAG = 13,     // bits that go along
    parameter LAYERS = BOXES > 6 ? 6 : BOXES > 4 ? 5 : BOXES > 2 ? 3 : BOXES - 1,
    parameter STEPS = 7 + LAYERS
) (
    input  logic                clk,
    input  logic                rst,
    input  logic                step,
    input  logic                in_valid,
    input  logic [TAG-1:0]      in_tag,
    input  logic [BOXES-1:0]    in_used,
    input  logic [BOXES*96-1:0] in_lower,
    input  logic [BOXES*96-1:0] in_upper,
    input  logic [95:0]         in_origin,
    input  logic [95:0]         in_inverse,
    input  logic [31:0]         in_t_offset,
    input  logic [31:0]         in_t_min,
    input  logic [31:0]         in_t_max,
    input  logic [1:0]          fault,
    output logic                out_valid,
    output logic [TAG-1:0]      out_tag,
    output logic [BOXES*36-1:0] out_children
);
/*verilator no_inline_module*/
  // A digit a child, the first one lowest: its partner in a layer of the sorting network, or itself. 19 exchanges for
  // eight children, 12 for six, 5 for four; those with children that there are not fall away.
  localparam [191:0] EIGHT = 192'h75634120_73516240_76325410_67452301_32107654_54761032;
  localparam [191:0] SIX = 192'h76543210_76534120_76452301_76240513_76534120_76021435;
  localparam [191:0] FOUR = 192'h76543210_76543210_76543210_76543120_76542301_76541032;
  localparam [191:0] TWO = 192'h76543210_76543210_76543210_76543210_76543210_76543201;
  localparam [191:0] PARTNERS = BOXES > 6 ? EIGHT : BOXES > 4 ? SIX : BOXES > 2 ? FOUR : TWO;

  logic [STEPS:0] valid /*verilator split_var*/;
  logic [TAG-1:0] tag [STEPS + 1] /*verilator split_var*/;
  logic [31:0]    t_offset [5] /*verilator split_var*/;
  logic [63:0]    limits [7] /*verilator split_var*/;  // t_max, t_min
  logic [95:0]    inverse_1;
  logic [BOXES*36-1:0] children [LAYERS + 1] /*verilator split_var*/;
  logic [BOXES*36-1:0] sorted [LAYERS + 1] /*verilator split_var*/;  // by layer, before the register
  assign valid[0] = in_valid;
  assign tag[0] = in_tag;
  assign t_offset[0] = in_t_offset;
  assign limits[0] = {in_t_max, in_t_min};
  assign out_valid = valid[STEPS];
  assign out_tag = tag[STEPS];
  assign out_children = children[LAYERS];

  // Registers behind each step, the first step's lowest. Beyond one each they go where the work is: WORK is how many more a
  // step needs for the clock of the machine (docs/results/rtl.md).
  localparam [13*8-1:0] WORK = {{6{8'd0}}, 8'd0, 8'd2, 8'd7, 8'd0, 8'd0, 8'd5, 8'd7};
  function [STEPS*4-1:0] cuts(input integer stages);
    integer sum, so_far, total;
    total = 0;
    sum = 0;
    for (int n = 0; n < STEPS; n = n + 1) total = total + 32'(WORK[n*8 +: 8]);
    for (int n = 0; n < STEPS; n = n + 1) begin
      so_far = sum;
      sum = sum + 32'(WORK[n*8 +: 8]);
      cuts[n*4 +: 4] = stages <= STEPS ? 4'((n + 1) * stages / STEPS - n * stages / STEPS)
                                       : 4'(1 + (stages - STEPS) * sum / total - (stages - STEPS) * so_far / total);
    end
  endfunction
  localparam [STEPS*4-1:0] CUTS = cuts(STAGES);
  genvar i, k;
  generate
    for (k = 0; k < STEPS; k = k + 1) begin : stage
      localparam [3:0] CUT = CUTS[k*4 +: 4];
      intersection_valid #(CUT) of_valid(clk, rst, step, valid[k], valid[k + 1]);
      intersection_cut #(TAG, CUT) of_tag(clk, step, valid[k], tag[k], tag[k + 1]);
      if (k == 0) begin : inverse
        intersection_cut #(96, CUT) cut(clk, step, valid[k], in_inverse, inverse_1);
      end
      if (k < 4) begin : offset
        intersection_cut #(32, CUT) cut(clk, step, valid[k], t_offset[k], t_offset[k + 1]);
      end
      if (k < 6) begin : limit
        intersection_cut #(64, CUT) cut(clk, step, valid[k], limits[k], limits[k + 1]);
      end
      if (k >= 6) begin : order
        intersection_cut #(BOXES*36, CUT) cut(clk, step, valid[k], sorted[k - 6], children[k - 6]);
      end
    end
    for (i = 0; i < BOXES; i = i + 1) begin : child
      logic [32:0] result;
      logic [2:0]  slot;
      assign slot = fault == 2'd3 && i == 1 ? 3'd2 : i;
      ray_box_child #(CUTS[7*4-1:0]) test(
          .clk(clk), .step(step), .valid(valid[6:0]), .used(in_used[i]), .lower(in_lower[i*96 +: 96]),
          .upper(in_upper[i*96 +: 96]), .origin(in_origin), .inverse_0(in_inverse), .inverse_1(inverse_1),
          .t_offset_4(t_offset[4]), .t_min_6(limits[6][31:0]), .t_max_6(limits[6][63:32]), .fault(fault == 2'd1),
          .result(result));
      assign sorted[0][i*36 +: 36] = {result[32:1], slot, result[0]};
    end
    for (k = 0; k < LAYERS; k = k + 1) begin : layer
      for (i = 0; i < BOXES; i = i + 1) begin : place
        localparam [31:0] PARTNER = {28'd0, PARTNERS[(k*8 + i)*4 +: 4]};
        if (PARTNER == i || PARTNER >= BOXES) begin : stays
          assign sorted[k + 1][i*36 +: 36] = children[k][i*36 +: 36];
        end else if (PARTNER > i) begin : exchange
          logic above;
          assign above = children[k][i*36 +: 36] > children[k][PARTNER*36 +: 36];
          assign sorted[k + 1][i*36 +: 36] = above ? children[k][PARTNER*36 +: 36] : children[k][i*36 +: 36];
          assign sorted[k + 1][PARTNER*36 +: 36] = above ? children[k][i*36 +: 36] : children[k][PARTNER*36 +: 36];
        end
      end
    end
  endgenerate
endmodule

module ray_box_unit #(
    parameter COUNT = 4,                // pipelines
    parameter BOXES = 6,                // children of a node that a test covers
    parameter STAGES = 12,              // of a pipeline
    parameter LONGEST = 0,              // edges by which the straps can delay a result
    parameter RAYS = 256,               // warp buffer entries x 32
    parameter RAY_BITS = $clog2(RAYS),
    parameter TAG = RAY_BITS + 5        // ray, number of its test, last
) (
    input  logic                        clk,
    input  logic                        rst,             // synchronous
    input  logic                        step,            // time passes: a cycle of the unit
    // Straps: constant while the unit works.
    input  logic [3:0]                  cfg_count,       // 1 to COUNT
    input  logic [6:0]                  cfg_interval,    // edges between two tests of a pipeline, 1 to 127
    input  logic [6:0]                  cfg_delay,       // 0 to LONGEST: latency less STAGES
`ifdef INTERSECTION_FAULTS
    input  logic [1:0]                  fault,           // 1 comparison, 2 lost entry, 3 slot
`endif
    // A ray asks for the tests of its node.
    input  logic                        push_valid,
    output logic                        push_ready,
    input  logic [RAY_BITS-1:0]         push_ray,
    // Rays that leave the queue at the next step, and how many tests each asks for.
    output logic [COUNT-1:0]            start_valid,
    output logic [COUNT*RAY_BITS-1:0]   start_ray,
    input  logic [COUNT*4-1:0]          start_tests,
    // Tests that begin at the next step, and their operands.
    output logic [COUNT-1:0]            test_valid,
    output logic [COUNT*RAY_BITS-1:0]   test_ray,
    output logic [COUNT*4-1:0]          test_number,
    input  logic [COUNT*BOXES-1:0]      test_used,
    input  logic [COUNT*BOXES*96-1:0]   test_lower,
    input  logic [COUNT*BOXES*96-1:0]   test_upper,
    input  logic [COUNT*96-1:0]         test_origin,
    input  logic [COUNT*96-1:0]         test_inverse,
    input  logic [COUNT*32-1:0]         test_t_offset,
    input  logic [COUNT*32-1:0]         test_t_min,
    input  logic [COUNT*32-1:0]         test_t_max,
    // Results, there until the next step.
    output logic [COUNT-1:0]            result_valid,
    output logic [COUNT*RAY_BITS-1:0]   result_ray,
    output logic [COUNT*4-1:0]          result_number,
    output logic [COUNT-1:0]            result_last,     // the ray's
    output logic [COUNT*BOXES*36-1:0]   result_children, // in order: beyond t_max, slot, entry t, miss
    // State.
    output logic [RAY_BITS:0]           level,           // rays in the queue
    output logic [COUNT-1:0]            busy,            // pipelines that can start nothing
    output logic [RAY_BITS:0]           in_flight,       // rays that have started and have no result yet
    output logic                        idle             // no ray in it
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
      logic                valid;
      logic [TAG-1:0]      tag, out_tag;
      logic [BOXES*36-1:0] children;
      ray_box_pipeline #(.BOXES(BOXES), .STAGES(STAGES), .TAG(TAG)) boxes(
          .clk(clk), .rst(rst), .step(step), .in_valid(test_valid[p]),
          .in_tag({test_last[p], test_number[p*4 +: 4], test_ray[p*RAY_BITS +: RAY_BITS]}),
          .in_used(test_used[p*BOXES +: BOXES]), .in_lower(test_lower[p*BOXES*96 +: BOXES*96]),
          .in_upper(test_upper[p*BOXES*96 +: BOXES*96]), .in_origin(test_origin[p*96 +: 96]),
          .in_inverse(test_inverse[p*96 +: 96]), .in_t_offset(test_t_offset[p*32 +: 32]),
          .in_t_min(test_t_min[p*32 +: 32]), .in_t_max(test_t_max[p*32 +: 32]), .fault(fault), .out_valid(valid),
          .out_tag(tag), .out_children(children));
      intersection_delay #(.WIDTH(TAG + BOXES*36), .LONGEST(LONGEST)) delay(
          .clk(clk), .rst(rst), .step(step), .cfg_delay(cfg_delay), .in_valid(valid), .in({tag, children}),
          .out_valid(result_valid[p]), .out({out_tag, result_children[p*BOXES*36 +: BOXES*36]}));
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
