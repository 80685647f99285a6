// SPDX-License-Identifier: Apache-2.0
// What the intersection units have in common: the queue of rays, served in order, and for each pipeline what is being
// tested in it and when it can start again. Pins and timing: docs/model/rtl_bridge.md.
module intersection_queue #(
    parameter COUNT = 4,      // pipelines
    parameter RAYS = 256,     // warp buffer entries x 32: a place for each in the queue
    parameter RAY_BITS = $clog2(RAYS)
) (
    input  logic                      clk,
    input  logic                      rst,
    input  logic                      step,
    input  logic [3:0]                cfg_count,
    input  logic [6:0]                cfg_interval,
    input  logic                      fault,          // constant 0 but in the tests: a ray is lost
    input  logic                      push_valid,
    output logic                      push_ready,
    input  logic [RAY_BITS-1:0]       push_ray,
    output logic [COUNT-1:0]          start_valid,    // a ray leaves the queue for this pipeline
    output logic [COUNT*RAY_BITS-1:0] start_ray,
    input  logic [COUNT*4-1:0]        start_tests,    // that it asks for
    output logic [COUNT-1:0]          test_valid,     // a test begins
    output logic [COUNT*RAY_BITS-1:0] test_ray,
    output logic [COUNT*4-1:0]        test_number,
    output logic [COUNT-1:0]          test_last,
    output logic [COUNT-1:0]          busy,           // can start nothing at this edge
    output logic [RAY_BITS:0]         level
);
  logic [RAY_BITS-1:0]       queue [RAYS];
  logic [RAY_BITS-1:0]       head;
  logic [COUNT*7-1:0]        waiting;  // edges until the pipeline may begin a test
  logic [COUNT*4-1:0]        left;     // tests of the ray that have not begun
  logic [COUNT*4-1:0]        number;   // of the next of them
  logic [COUNT*RAY_BITS-1:0] ray;
  logic [RAY_BITS:0]         taken;

  assign push_ready = level != (RAY_BITS+1)'(RAYS);

  always_comb begin
    taken = '0;
    for (int p = 0; p < COUNT; p = p + 1) begin
      busy[p] = waiting[p*7 +: 7] != 7'd0 | left[p*4 +: 4] != 4'd0;
      start_ray[p*RAY_BITS +: RAY_BITS] = queue[head + taken[RAY_BITS-1:0]];
      start_valid[p] = p < cfg_count & ~busy[p] & taken != level;
      taken = taken + {{RAY_BITS{1'b0}}, start_valid[p]};
      test_valid[p] = start_valid[p] | (waiting[p*7 +: 7] == 7'd0 & left[p*4 +: 4] != 4'd0);
      test_ray[p*RAY_BITS +: RAY_BITS] = start_valid[p] ? start_ray[p*RAY_BITS +: RAY_BITS] : ray[p*RAY_BITS +: RAY_BITS];
      test_number[p*4 +: 4] = start_valid[p] ? 4'd0 : number[p*4 +: 4];
      test_last[p] = (start_valid[p] ? start_tests[p*4 +: 4] : left[p*4 +: 4]) == 4'd1;
    end
  end

  always_ff @(posedge clk) begin
    if (rst) begin
      head <= '0;
      level <= '0;
      waiting <= '0;
      left <= '0;
    end else begin
      level <= level + {{RAY_BITS{1'b0}}, push_valid & push_ready & ~(fault & push_ray[2:0] == 3'd5)} -
               (step ? taken : '0);
      if (step) begin
        head <= head + taken[RAY_BITS-1:0];
        for (int p = 0; p < COUNT; p = p + 1) begin
          if (test_valid[p]) begin
            waiting[p*7 +: 7] <= cfg_interval - 7'd1;
            left[p*4 +: 4] <= (start_valid[p] ? start_tests[p*4 +: 4] : left[p*4 +: 4]) - 4'd1;
          end else if (waiting[p*7 +: 7] != 7'd0) begin
            waiting[p*7 +: 7] <= waiting[p*7 +: 7] - 7'd1;
          end
        end
      end
    end
  end

  always_ff @(posedge clk) begin
    if (push_valid & push_ready) queue[head + level[RAY_BITS-1:0]] <= push_ray;
    for (int p = 0; p < COUNT; p = p + 1) begin
      if (step & test_valid[p]) begin
        ray[p*RAY_BITS +: RAY_BITS] <= test_ray[p*RAY_BITS +: RAY_BITS];
        number[p*4 +: 4] <= test_number[p*4 +: 4] + 4'd1;
      end
    end
  end
endmodule

// A result's way from the last stage to the pins when the unit's latency is longer than its pipeline.
module intersection_delay #(
    parameter WIDTH = 1,
    parameter LONGEST = 0  // edges, a power of two less one; 0: none
) (
    input  logic             clk,
    input  logic             rst,
    input  logic             step,
    input  logic [6:0]       cfg_delay,
    input  logic             in_valid,
    input  logic [WIDTH-1:0] in,
    output logic             out_valid,
    output logic [WIDTH-1:0] out
);
  generate
    if (LONGEST == 0) begin : none
      assign out_valid = in_valid;
      assign out = in;
    end else begin : line
      localparam BITS = $clog2(LONGEST);
      logic [WIDTH-1:0]    places [LONGEST + 1];
      logic [LONGEST:0]    full;
      logic [BITS-1:0]     next, last;
      assign last = next - cfg_delay[BITS-1:0];
      assign out_valid = cfg_delay == 7'd0 ? in_valid : full[last];
      assign out = cfg_delay == 7'd0 ? in : places[last];
      always_ff @(posedge clk) begin
        if (rst) begin
          next <= '0;
          full <= '0;
        end else if (step) begin
          next <= next + 1'b1;
          full[next] <= in_valid;
        end
        if (step & in_valid) places[next] <= in;
      end
    end
  endgenerate
endmodule

// The registers behind a step of a pipeline: CUT of them, 0 to 15. More than one is for synthesis to move into the step.
module intersection_cut #(
    parameter WIDTH = 1,
    parameter CUT = 1
) (
    input  logic             clk,
    input  logic             step,
    input  logic             load,  // in is valid
    input  logic [WIDTH-1:0] in,
    output logic [WIDTH-1:0] out
);
  generate
    if (CUT == 0) begin : wire_only
      assign out = in;
    end else if (CUT == 1) begin : register
      always_ff @(posedge clk) if (step & load) out <= in;
    end else begin : registers
      localparam BITS = 32'(CUT) * WIDTH;
      logic [BITS-1:0] places;
      assign out = places[BITS-1 -: WIDTH];
      always_ff @(posedge clk) begin
        if (step & load) places[WIDTH-1:0] <= in;
        if (step) places[BITS-1:WIDTH] <= places[BITS-WIDTH-1:0];
      end
    end
  endgenerate
endmodule

// The same of whether what they hold is valid.
module intersection_valid #(
    parameter CUT = 1
) (
    input  logic clk,
    input  logic rst,
    input  logic step,
    input  logic in,
    output logic out
);
  generate
    if (CUT == 0) begin : wire_only
      assign out = in;
    end else if (CUT == 1) begin : register
      always_ff @(posedge clk) begin
        if (rst) out <= 1'b0;
        else if (step) out <= in;
      end
    end else begin : registers
      localparam BITS = 32'(CUT);
      logic [BITS-1:0] places;
      assign out = places[BITS-1];
      always_ff @(posedge clk) begin
        if (rst) places <= '0;
        else if (step) places <= {places[BITS-2:0], in};
      end
    end
  endgenerate
endmodule
